/* SPDX-License-Identifier: Apache-2.0 */
/* Assimp's door, a part of the program nephos_assimp. Cameras hang in a tree of nodes, each with a transform that keys
 * may replace: positions and scalings go along lines between keys, rotations along great circles. Assimp passes a
 * glTF's keys on, and not how it interpolates between them: steps, and splines, too, become lines. */
#include "mesh/assimp_reader.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/scene.h>
#include <assimp/version.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "core/text_copy.h"

/* Default for an animation without a number of ticks a second. */
static const double default_ticks_per_s = 25.0;

static const struct aiScene *get_scene(const np_assimp_scene *scene) {
  return (const struct aiScene *)(const void *)scene;
}

/* ---- Keys ---- */

/* Keys of a node in the first animation; NULL: it has none. */
static const struct aiNodeAnim *get_keys(const struct aiScene *scene, const struct aiNode *node) {
  const struct aiAnimation *animation = scene->mNumAnimations ? scene->mAnimations[0] : NULL;
  for (unsigned i = 0; animation && i < animation->mNumChannels; i++)
    if (!strcmp(animation->mChannels[i]->mNodeName.data, node->mName.data)) return animation->mChannels[i];
  return NULL;
}

static double get_ticks_per_s(const struct aiScene *scene) {
  const double ticks = scene->mNumAnimations ? scene->mAnimations[0]->mTicksPerSecond : 0.0;
  return ticks > 0.0 ? ticks : default_ticks_per_s;
}

/* The keys before and after a time, and the weight of the second; the same key before the first and after the last. */
typedef struct key_pair {
  unsigned first, second;
  double share;
} key_pair;

/* Time of a key, the first member of keys of any kind. */
static double get_time(const void *keys, size_t key_bytes, unsigned index) {
  double time;
  memcpy(&time, (const char *)keys + index * key_bytes, sizeof time);
  return time;
}

static key_pair search_keys(const void *keys, size_t key_bytes, unsigned count, double ticks) {
  unsigned next = 0;
  while (next < count && get_time(keys, key_bytes, next) <= ticks) next++;
  const key_pair pair = {next > 0 ? next - 1 : 0, next < count ? next : count - 1, 0.0};
  const double begin = get_time(keys, key_bytes, pair.first), span = get_time(keys, key_bytes, pair.second) - begin;
  return (key_pair){pair.first, pair.second, span > 0.0 ? (ticks - begin) / span : 0.0};
}

static struct aiVector3D mix(const struct aiVectorKey *keys, unsigned count, double ticks) {
  const key_pair pair = search_keys(keys, sizeof *keys, count, ticks);
  const struct aiVector3D *a = &keys[pair.first].mValue, *b = &keys[pair.second].mValue;
  const float share = (float)pair.share;
  return (struct aiVector3D){a->x + share * (b->x - a->x), a->y + share * (b->y - a->y), a->z + share * (b->z - a->z)};
}

static struct aiQuaternion turn(const struct aiQuatKey *keys, unsigned count, double ticks) {
  const key_pair pair = search_keys(keys, sizeof *keys, count, ticks);
  struct aiQuaternion out;
  aiQuaternionInterpolate(&out, &keys[pair.first].mValue, &keys[pair.second].mValue, (float)pair.share);
  aiQuaternionNormalize(&out);
  return out;
}

/* ---- Nodes ---- */

/* Local transform of a node; translation, rotation and scale without keys are the node's. */
static struct aiMatrix4x4 get_transform(const struct aiScene *scene, const struct aiNode *node, double ticks) {
  const struct aiNodeAnim *keys = get_keys(scene, node);
  if (!keys) return node->mTransformation;
  struct aiVector3D scaling, position;
  struct aiQuaternion rotation;
  aiDecomposeMatrix(&node->mTransformation, &scaling, &rotation, &position);
  if (keys->mNumPositionKeys) position = mix(keys->mPositionKeys, keys->mNumPositionKeys, ticks);
  if (keys->mNumRotationKeys) rotation = turn(keys->mRotationKeys, keys->mNumRotationKeys, ticks);
  if (keys->mNumScalingKeys) scaling = mix(keys->mScalingKeys, keys->mNumScalingKeys, ticks);
  struct aiMatrix4x4 out;
  aiMatrix4FromScalingQuaternionPosition(&out, &scaling, &rotation, &position);
  return out;
}

/* Transform to the world, through all ancestors of the node. */
static struct aiMatrix4x4 get_to_world(const struct aiScene *scene, const struct aiNode *node, double ticks) {
  struct aiMatrix4x4 out;
  aiIdentityMatrix4(&out);
  for (; node; node = node->mParent) {
    struct aiMatrix4x4 outer = get_transform(scene, node, ticks);
    aiMultiplyMatrix4(&outer, &out);
    out = outer;
  }
  return out;
}

/* The node with a name in a tree; NULL: none. */
static const struct aiNode *search_node(const struct aiNode *node, const char *name) {
  if (!node || !strcmp(node->mName.data, name)) return node;
  const struct aiNode *found = NULL;
  for (unsigned i = 0; i < node->mNumChildren && !found; i++) found = search_node(node->mChildren[i], name);
  return found;
}

static const struct aiNode *get_node(const struct aiScene *scene, const struct aiCamera *camera) {
  return search_node(scene->mRootNode, camera->mName.data);
}

/* ---- Files ---- */

static FILE *get_stream(struct aiFile *file) { return (FILE *)(void *)file->UserData; }

static size_t read_stream(struct aiFile *file, char *out, size_t size, size_t count) {
  return fread(out, size, count, get_stream(file));
}

static size_t write_nothing(struct aiFile *file, const char *bytes, size_t size, size_t count) {
  (void)file, (void)bytes, (void)size, (void)count;
  return 0;
}

static void flush_nothing(struct aiFile *file) { (void)file; }

static size_t get_offset(struct aiFile *file) {
  const long at = ftell(get_stream(file));
  return at > 0 ? (size_t)at : 0;
}

static size_t get_size(struct aiFile *file) {
  struct stat facts;
  return fstat(fileno(get_stream(file)), &facts) || facts.st_size < 0 ? 0 : (size_t)facts.st_size;
}

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin) {
  static const int whence[] = {[aiOrigin_SET] = SEEK_SET, [aiOrigin_CUR] = SEEK_CUR, [aiOrigin_END] = SEEK_END};
  return fseek(get_stream(file), (long)offset, whence[origin]) ? aiReturn_FAILURE : aiReturn_SUCCESS;
}

static void close_stream(struct aiFileIO *files, struct aiFile *file) {
  (void)files;
  if (file) fclose(get_stream(file));
  free(file);
}

typedef struct file_access {
  const char *path; /* path of the mesh */
  void (*note_bytes)(uint64_t bytes);
  char message[256]; /* message about a refused file; empty: none */
} file_access;

/* Whether a file is the mesh itself, or below its folder with all links resolved. */
static bool is_allowed(const file_access *access, const char *path) {
  char folder[PATH_MAX], root[PATH_MAX], real[PATH_MAX];
  const char *slash = strrchr(access->path, '/');
  if (!strcmp(path, access->path)) return true;
  const int length = slash ? (int)(slash - access->path) + 1 : 2;
  const int printed = snprintf(folder, sizeof folder, "%.*s", length, slash ? access->path : "./");
  if (printed >= PATH_MAX || !realpath(folder, root) || !realpath(path, real)) return false;
  const size_t count = strcmp(root, "/") ? strlen(root) : 0;
  return !strncmp(real, root, count) && real[count] == '/';
}

/* Opens regular files alone: reading others might never end. */
static struct aiFile *open_stream(struct aiFileIO *files, const char *path, const char *mode) {
  file_access *access = (void *)files->UserData;
  struct stat facts;
  if (strcspn(mode, "wa+") != strlen(mode) || stat(path, &facts) || !S_ISREG(facts.st_mode)) return NULL;
  if (!is_allowed(access, path)) {
    char shown[104];
    np_text_copy_short(shown, sizeof shown, path);
    const int length = snprintf(access->message, sizeof access->message,
                                "it names %s: a mesh may name files in its own folder and below it alone", shown);
    if (length >= (int)sizeof access->message) np_text_end_short(access->message, sizeof access->message);
    return NULL;
  }
  struct aiFile *file = malloc(sizeof *file);
  FILE *stream = file ? fopen(path, mode) : NULL;
  if (!stream) return free(file), NULL;
  *file = (struct aiFile){.ReadProc = read_stream,
                          .WriteProc = write_nothing,
                          .TellProc = get_offset,
                          .FileSizeProc = get_size,
                          .SeekProc = seek,
                          .FlushProc = flush_nothing,
                          .UserData = (char *)stream};
  access->note_bytes(get_size(file));
  return file;
}

/* Opens a file without Assimp's post-processing: its assertions, which packages leave enabled, end the program on
 * damaged meshes. */
const np_assimp_scene *np_assimp_open(const char *path, void (*note_bytes)(uint64_t bytes), const char **out_message) {
  static file_access access;
  access = (file_access){path, note_bytes, ""};
  struct aiFileIO files = {open_stream, close_stream, (char *)&access};
  const struct aiScene *scene = aiImportFileEx(path, 0, &files);
  if (!scene) *out_message = access.message[0] ? access.message : aiGetErrorString();
  return (const np_assimp_scene *)scene;
}

/* ---- Cameras ---- */

size_t np_assimp_count_cameras(const np_assimp_scene *scene) { return get_scene(scene)->mNumCameras; }

static void include_time(double ticks, double ticks_per_s, np_assimp_camera *out) {
  const double seconds = ticks / ticks_per_s;
  out->begin_s = fmin(out->begin_s, seconds);
  out->end_s = fmax(out->end_s, seconds);
}

static void include_keys(const struct aiNodeAnim *keys, double ticks_per_s, np_assimp_camera *out) {
  for (unsigned i = 0; i < keys->mNumPositionKeys; i++) include_time(keys->mPositionKeys[i].mTime, ticks_per_s, out);
  for (unsigned i = 0; i < keys->mNumRotationKeys; i++) include_time(keys->mRotationKeys[i].mTime, ticks_per_s, out);
  for (unsigned i = 0; i < keys->mNumScalingKeys; i++) include_time(keys->mScalingKeys[i].mTime, ticks_per_s, out);
}

/* Vertical angle of view. Assimp's horizontal angle is for an aspect of 1 where a glTF has none. Before Assimp 5.3 it
 * is the vertical one times the aspect (Assimp's pull request 4886). */
static double get_vertical_fov(const struct aiCamera *camera) {
  const double aspect = camera->mAspect > 0.0f ? (double)camera->mAspect : 1.0, fov = (double)camera->mHorizontalFOV;
  const bool is_product = aiGetVersionMajor() < 5 || (aiGetVersionMajor() == 5 && aiGetVersionMinor() < 3);
  return is_product ? fov / aspect : 2.0 * atan(tan(0.5 * fov) / aspect);
}

void np_assimp_describe_camera(const np_assimp_scene *opened, size_t index, np_assimp_camera *out) {
  const struct aiScene *scene = get_scene(opened);
  const struct aiCamera *camera = scene->mCameras[index];
  *out = (np_assimp_camera){get_vertical_fov(camera), HUGE_VAL, -HUGE_VAL, ""};
  np_text_copy_short(out->name, sizeof out->name, camera->mName.data);
  for (const struct aiNode *node = get_node(scene, camera); node; node = node->mParent) {
    const struct aiNodeAnim *keys = get_keys(scene, node);
    if (keys) include_keys(keys, get_ticks_per_s(scene), out);
  }
  if (!(out->begin_s <= out->end_s)) out->begin_s = out->end_s = 0.0;
}

/* A direction of the camera in the world; false: it has no length. */
static bool turn_axis(const struct aiMatrix4x4 *m, const struct aiVector3D *v, double out[3]) {
  const double x = (double)v->x, y = (double)v->y, z = (double)v->z;
  out[0] = (double)m->a1 * x + (double)m->a2 * y + (double)m->a3 * z;
  out[1] = (double)m->b1 * x + (double)m->b2 * y + (double)m->b3 * z;
  out[2] = (double)m->c1 * x + (double)m->c2 * y + (double)m->c3 * z;
  const double length = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
  if (!(length > 1e-12) || !isfinite(length)) return false;
  for (int a = 0; a < 3; a++) out[a] /= length;
  return true;
}

/* Pose of a camera. A glTF's camera is at its node's origin; Assimp's position of the camera is the node's once
 * more. */
void np_assimp_get_pose(const np_assimp_scene *opened, size_t index, double seconds, np_assimp_pose *out) {
  const struct aiScene *scene = get_scene(opened);
  const struct aiCamera *camera = scene->mCameras[index];
  const struct aiMatrix4x4 m = get_to_world(scene, get_node(scene, camera), seconds * get_ticks_per_s(scene));
  *out = (np_assimp_pose){.at = {(double)m.a4, (double)m.b4, (double)m.c4}};
  if (!turn_axis(&m, &camera->mLookAt, out->forward) || !turn_axis(&m, &camera->mUp, out->up))
    *out = (np_assimp_pose){0};
}

/* ---- Meshes ---- */

size_t np_assimp_count_meshes(const np_assimp_scene *scene) { return get_scene(scene)->mNumMeshes; }

static unsigned count_triangles(const struct aiFace *face) {
  return face->mIndices && face->mNumIndices >= 3 ? face->mNumIndices - 2 : 0;
}

void np_assimp_describe_mesh(const np_assimp_scene *scene, size_t index, np_assimp_mesh *out) {
  const struct aiMesh *mesh = get_scene(scene)->mMeshes[index];
  *out = (np_assimp_mesh){0};
  if (!mesh->mVertices || !mesh->mFaces) return;
  for (unsigned i = 0; i < mesh->mNumFaces; i++) out->triangle_count += count_triangles(&mesh->mFaces[i]);
  if (!out->triangle_count) return;
  out->vertex_count = mesh->mNumVertices;
  out->has_normals = mesh->mNormals != NULL;
}

const float *np_assimp_get_positions(const np_assimp_scene *scene, size_t index) {
  return &get_scene(scene)->mMeshes[index]->mVertices->x;
}

const float *np_assimp_get_normals(const np_assimp_scene *scene, size_t index) {
  return &get_scene(scene)->mMeshes[index]->mNormals->x;
}

enum { CORNERS_MAX = 64 };

/* Corners of a polygon that remain to be cut off. */
typedef struct open_polygon {
  const struct aiVector3D *positions;
  uint32_t corners[CORNERS_MAX];
  unsigned count;
  double normal[3]; /* normal by Newell's sum */
} open_polygon;

static void subtract(const struct aiVector3D *a, const struct aiVector3D *b, double out[3]) {
  out[0] = (double)a->x - (double)b->x, out[1] = (double)a->y - (double)b->y, out[2] = (double)a->z - (double)b->z;
}

static void add_cross(const double a[3], const double b[3], double out[3]) {
  out[0] += a[1] * b[2] - a[2] * b[1];
  out[1] += a[2] * b[0] - a[0] * b[2];
  out[2] += a[0] * b[1] - a[1] * b[0];
}

static const struct aiVector3D *get_corner(const open_polygon *p, unsigned corner) {
  return &p->positions[p->corners[corner % p->count]];
}

/* Twice the area of a triangle, negative where its orientation is opposite to the polygon's. */
static double compute_area(const open_polygon *p, const struct aiVector3D *a, const struct aiVector3D *b,
                           const struct aiVector3D *c) {
  double u[3], v[3], cross[3] = {0};
  subtract(b, a, u);
  subtract(c, a, v);
  add_cross(u, v, cross);
  return cross[0] * p->normal[0] + cross[1] * p->normal[1] + cross[2] * p->normal[2];
}

/* Whether a corner is convex and its triangle holds no other (Meisters 1975, "Polygons Have Ears"). */
static int is_ear(const open_polygon *p, unsigned corner) {
  const struct aiVector3D *a = get_corner(p, corner + p->count - 1), *b = get_corner(p, corner),
                          *c = get_corner(p, corner + 1);
  if (!(compute_area(p, a, b, c) > 0.0)) return 0;
  for (unsigned k = 2; k + 1 < p->count; k++) {
    const struct aiVector3D *q = get_corner(p, corner + k);
    if (compute_area(p, a, b, q) > 0.0 && compute_area(p, b, c, q) > 0.0 && compute_area(p, c, a, q) > 0.0) return 0;
  }
  return 1;
}

static void start_polygon(const struct aiMesh *mesh, const struct aiFace *face, open_polygon *out) {
  *out = (open_polygon){.positions = mesh->mVertices, .count = face->mNumIndices};
  memcpy(out->corners, face->mIndices, face->mNumIndices * sizeof *out->corners);
  for (unsigned k = 1; k + 1 < out->count; k++) {
    double u[3], v[3];
    subtract(get_corner(out, k), get_corner(out, 0), u);
    subtract(get_corner(out, k + 1), get_corner(out, 0), v);
    add_cross(u, v, out->normal);
  }
}

/* Triangulates a polygon by cutting off ears, or any corner where the polygon is not simple. */
static uint32_t *cut_polygon(open_polygon *p, uint32_t *out) {
  while (p->count >= 3) {
    unsigned ear = 0;
    while (ear < p->count && !is_ear(p, ear)) ear++;
    if (ear == p->count) ear = 0;
    *out++ = p->corners[(ear + p->count - 1) % p->count];
    *out++ = p->corners[ear];
    *out++ = p->corners[(ear + 1) % p->count];
    p->count--;
    memmove(p->corners + ear, p->corners + ear + 1, (p->count - ear) * sizeof *p->corners);
  }
  return out;
}

static int can_be_cut(const struct aiMesh *mesh, const struct aiFace *face) {
  int is_sound = face->mNumIndices > 3 && face->mNumIndices <= CORNERS_MAX;
  for (unsigned k = 0; is_sound && k < face->mNumIndices; k++) is_sound = face->mIndices[k] < mesh->mNumVertices;
  return is_sound;
}

/* Passes a triangle on; a polygon of very many corners, or with invalid indices, as a fan. */
static void visit_face(const struct aiMesh *mesh, const struct aiFace *face, np_assimp_visit_triangles visit,
                       void *user) {
  open_polygon p;
  uint32_t cut[3 * CORNERS_MAX];
  if (can_be_cut(mesh, face)) {
    start_polygon(mesh, face, &p);
    visit(user, cut, (size_t)(cut_polygon(&p, cut) - cut));
    return;
  }
  for (unsigned k = 0; k < count_triangles(face); k++)
    visit(user, (uint32_t[]){face->mIndices[0], face->mIndices[k + 1], face->mIndices[k + 2]}, 3);
}

void np_assimp_visit_faces(const np_assimp_scene *scene, size_t index, np_assimp_visit_triangles visit, void *user) {
  const struct aiMesh *mesh = get_scene(scene)->mMeshes[index];
  for (unsigned i = 0; i < mesh->mNumFaces; i++) visit_face(mesh, &mesh->mFaces[i], visit, user);
}

/* ---- Places ---- */

static void visit_node(const struct aiNode *node, const struct aiMatrix4x4 *outer, np_assimp_visit_place visit,
                       void *user) {
  struct aiMatrix4x4 m = *outer;
  aiMultiplyMatrix4(&m, &node->mTransformation);
  np_assimp_place place = {0,
                           {{(double)m.a1, (double)m.a2, (double)m.a3, (double)m.a4},
                            {(double)m.b1, (double)m.b2, (double)m.b3, (double)m.b4},
                            {(double)m.c1, (double)m.c2, (double)m.c3, (double)m.c4}}};
  for (unsigned i = 0; i < node->mNumMeshes; i++) {
    place.mesh = node->mMeshes[i];
    visit(user, &place);
  }
  for (unsigned i = 0; i < node->mNumChildren; i++) visit_node(node->mChildren[i], &m, visit, user);
}

void np_assimp_visit_places(const np_assimp_scene *scene, np_assimp_visit_place visit, void *user) {
  struct aiMatrix4x4 identity;
  aiIdentityMatrix4(&identity);
  if (get_scene(scene)->mRootNode) visit_node(get_scene(scene)->mRootNode, &identity, visit, user);
}
