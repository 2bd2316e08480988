/* SPDX-License-Identifier: Apache-2.0 */
/* Files that a raster names: those below its folder are read, others refused; a listener on this machine hears of none.
 */
#include "test_rasters.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- A listener ---- */

typedef struct listener {
  int socket;
  char url[100], address[80]; /* address as a file name of GDAL, and plain */
} listener;

static listener listen_here(void) {
  listener l = {.socket = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
  struct sockaddr_in at = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
  socklen_t size = sizeof at;
  assert_true(l.socket >= 0);
  assert_int_equal(bind(l.socket, (struct sockaddr *)&at, size) + listen(l.socket, 8), 0);
  assert_int_equal(getsockname(l.socket, (struct sockaddr *)&at, &size), 0);
  (void)snprintf(l.address, sizeof l.address, "http://127.0.0.1:%u/x.tif", (unsigned)ntohs(at.sin_port));
  (void)snprintf(l.url, sizeof l.url, "/vsicurl/%s", l.address);
  return l;
}

static void assert_unheard(const listener *l) { assert_int_equal(accept(l->socket, NULL, NULL), -1); }

/* ---- Refusals ---- */

/* Described, checked and loaded, it is refused with one message. */
static void assert_refused(test_fixture *f, const char *path, const char *complaint) {
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  unsigned size[2];
  char *text;
  test_log_clear(&f->log);
  assert_int_equal(load(f, path, NULL, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, path, complaint);
  assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, path, complaint);
  assert_int_equal(neph_terrain_describe_file(f->context, path, NEPH_TEXT_JSON, &text), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, path, complaint);
}

static void assert_read(test_fixture *f, const char *path) {
  np_heightfield field;
  test_log_clear(&f->log);
  const neph_result result = load(f, path, NULL, &field);
  if (result) fail_msg("%s: %s", path, f->log.text);
  np_heightfield_destroy(f->context, &field);
}

/* A .vrt of one band, of what stands in it. */
static char *write_vrt(const test_fixture *f, const char *name, const char *members, const char *class,
                       const char *inside) {
  return write_text(f, name,
                    "<VRTDataset rasterXSize=\"3\" rasterYSize=\"2\">%s<VRTRasterBand dataType=\"Float32\" band=\"1\" "
                    "%s>%s</VRTRasterBand></VRTDataset>",
                    members, class, inside);
}

#define SOURCE(relative, name)                                                                                         \
  "<SimpleSource><SourceFilename relativeToVRT=\"" relative "\">" name "</SourceFilename></SimpleSource>"

/* The listener's address stands for @. */
static char *put_address(const char *text, const char *address) {
  char *out = malloc(2000);
  const char *at = strchr(text, '@');
  assert_non_null(out);
  (void)snprintf(out, 2000, "%.*s%s%s", (int)(at ? at - text : (long)strlen(text)), text, at ? address : "",
                 at ? at + 1 : "");
  return out;
}

static const struct {
  const char *class, *inside, *complaint;
} named[] = {
    {"", SOURCE("0", "@"), "it names /vsicurl/http://"},
    {"", SOURCE("1", "@"), "it names /vsicurl/http://"},
    {"", SOURCE("0", "grid.asc"), "it names grid.asc: a .vrt may name rasters in its own folder and below it alone"},
    {"", SOURCE("1", "../grid.asc"), "it names ../grid.asc: a .vrt may name rasters in its own folder"},
    {"", SOURCE("1", "b/../../grid.asc"), "it names b/../../grid.asc: a .vrt may name"},
    {"", SOURCE("1", "/dev/zero.tif"), "it names /dev/zero.tif: a .vrt may name"},
    {"", SOURCE("1", "GTIFF_DIR:1:grid.tif"), "it names GTIFF_DIR:1:grid.tif: a .vrt may name"},
    {"", SOURCE("1", "vrt://grid.tif"), "it names vrt://grid.tif: a .vrt may name"},
    {"", SOURCE("1", ""), "it names nothing: a .vrt may name"},
    {"", SOURCE("1", "secret.bin"), "it names secret.bin: its ending is that of no raster of heights"},
    {"", SOURCE("1", "outside.asc"), "outside.asc: it is a link that leads out of the raster's folder"},
    {"", SOURCE("1", "up/grid.asc"), "grid.asc: it is a link that leads out of the raster's folder"},
    {"", SOURCE("1", "pipe.tif"), "pipe.tif: it is a device, a pipe or a socket"},
    {"", SOURCE("1", "named.vrt"), "named.vrt is nested in 8 others"},
    {"", "<Overview><SourceFilename relativeToVRT=\"0\">@</SourceFilename></Overview>", "it names /vsicurl/http://"},
    {"subClass=\"VRTRawRasterBand\"", "<SourceFilename relativeToVRT=\"1\">grid.asc</SourceFilename>",
     "it has a part of the kind VRTRawRasterBand: its bands must be of sources or warped ones"},
    {"subClass=\"VRTDerivedRasterBand\"", "<PixelFunctionLanguage>Python</PixelFunctionLanguage>",
     "it has a part of the kind VRTDerivedRasterBand"},
    {"", "<PixelFunctionCode>import os</PixelFunctionCode>", "it holds the element PixelFunctionCode: must hold"},
    {"", "<OpenOptions><OOI key=\"ROOT_PATH\">/etc</OOI></OpenOptions>", "it has the open option ROOT_PATH"},
    {"", "<Mask><Mask/></Mask>", "it holds the element Mask"},
};

static void files_outside_the_folder_are_refused(void **state) {
  test_fixture *f = *state;
  const listener l = listen_here();
  char *outside = write_grid(f, "grid.asc", 499900, northing_m, "1 2 3\n4 5 6"), *folder = test_path(f->folder, "in");
  char *link = test_path(f->folder, "in/outside.asc"), *up = test_path(f->folder, "in/up"),
       *pipe = test_path(f->folder, "in/pipe.tif");
  assert_int_equal(mkdir(folder, 0777) + symlink(outside, link) + symlink("..", up) + mkfifo(pipe, 0600), 0);
  for (size_t i = 0; i < sizeof named / sizeof *named; i++) {
    char *inside = put_address(named[i].inside, l.url);
    char *path = write_vrt(f, "in/named.vrt", grid_members, named[i].class, inside);
    assert_refused(f, path, named[i].complaint);
    assert_unheard(&l);
    free(path);
    free(inside);
  }
  close(l.socket);
  char *const names[] = {outside, folder, link, up, pipe};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) free(names[i]);
}

/* In folders below, one in the other, by a link to the .vrt, and through a warped one. */
static void files_below_the_folder_are_read(void **state) {
  test_fixture *f = *state;
  char *folder = test_path(f->folder, "tiles"), *link = test_path(f->folder, "link.vrt");
  assert_int_equal(mkdir(folder, 0777), 0);
  char *paths[] = {
      write_grid(f, "tiles/grid.asc", 499900, northing_m, "1 2 3\n4 5 6"),
      write_vrt(f, "tiles/inner.vrt", grid_members, "", SOURCE("1", "grid.asc")),
      write_vrt(f, "outer.vrt", grid_members, "subClass=\"VRTSourcedRasterBand\"", SOURCE("1", "tiles/inner.vrt")),
      write_vrt(f, "options.vrt", grid_members, "",
                "<SimpleSource><SourceFilename relativeToVRT=\"1\">tiles/grid.asc</SourceFilename>"
                "<OpenOptions><OOI key=\"DATATYPE\">Float32</OOI></OpenOptions></SimpleSource>")};
  assert_int_equal(symlink("tiles/inner.vrt", link), 0);
  for (size_t i = 1; i < sizeof paths / sizeof *paths; i++) assert_read(f, paths[i]);
  assert_read(f, link);
  char *bad = write_vrt(f, "tiles/inner.vrt", grid_members, "", SOURCE("1", "../outer.vrt"));
  assert_refused(f, paths[2], "inner.vrt names ../outer.vrt: a .vrt may name rasters in its own folder");
  free(bad);
  for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) free(paths[i]);
  free(link);
  free(folder);
}

/* ---- Beside a file, and in it ---- */

static const char overview_xml[] = "<Metadata domain=\"OVERVIEWS\"><MDI key=\"OVERVIEW_FILE\">@</MDI></Metadata>";

/* An overview that metadata name, in the .vrt and beside it; one that is a .vrt under another name; a coordinate system
 * that is an address, or needs a file. */
static void files_that_hang_on_a_raster_are_refused(void **state) {
  test_fixture *f = *state;
  const listener l = listen_here();
  char *grid = write_grid(f, "grid.asc", 499900, northing_m, "1 2 3\n4 5 6");
  char *metadata = put_address(overview_xml, l.url), *source = put_address(SOURCE("0", "@"), l.url);
  char *members = malloc(2000);
  (void)snprintf(members, 2000, "%s%s", grid_members, metadata);
  char *path = write_vrt(f, "a.vrt", members, "", SOURCE("1", "grid.asc"));
  assert_refused(f, path, "name a file of overviews, OVERVIEW_FILE, which is not allowed");
  free(path);
  static const char *const systems[] = {"@", "+proj=longlat +ellps=bessel +nadgrids=/dev/zero",
                                        "+proj=longlat +ellps=bessel +nadgrids=@"};
  for (size_t i = 0; i < 3; i++) {
    char *system = put_address(systems[i], i ? l.address : l.url);
    (void)snprintf(members, 2000, "<SRS>%s</SRS><GeoTransform>0, 1, 0, 0, 0, -1</GeoTransform>", system);
    path = write_vrt(f, "a.vrt", members, "", SOURCE("1", "grid.asc"));
    assert_refused(f, path, "a coordinate system in it is");
    free(path);
    free(system);
  }
  path = write_vrt(f, "a.vrt", grid_members, "", SOURCE("1", "grid.asc"));
  assert_read(f, path);
  char *side = write_vrt(f, "a.vrt.ovr", grid_members, "", source);
  assert_refused(f, path, "a.vrt.ovr: begins as XML, which its ending does not say");
  assert_int_equal(unlink(side), 0);
  free(side);
  side = write_text(f, "grid.asc.aux.xml", "<PAMDataset>%s</PAMDataset>", metadata);
  assert_refused(f, path, "grid.asc: its metadata (or its .aux.xml) name a file of overviews");
  free(path);
  path = write_vrt(f, "fake.tif", grid_members, "", source);
  assert_refused(f, path, "fake.tif: begins as XML, which its ending does not say");
  assert_unheard(&l);
  close(l.socket);
  char *const names[] = {grid, metadata, source, members, path, side};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) free(names[i]);
}

static void systems_of_the_scene_open_nothing(void **state) {
  test_fixture *f = *state;
  const listener l = listen_here();
  static const char *const systems[] = {"@",
                                        "/dev/zero",
                                        "./utm.prj",
                                        "+proj=longlat +nadgrids=/dev/zero",
                                        "ESRI::/dev/zero",
                                        "esri::../zero.prj",
                                        "dict:/dev/zero,x",
                                        "+proj=utm +zone=11 +init=/dev/zero:1",
                                        "BOUNDCRS[SOURCECRS[],PARAMETERFILE[\"A difference file\",\"/dev/zero\"]]",
                                        "PROJCS[\"x\",EXTENSION[\"PROJ4\",\"+proj=utm +nadgrids=/dev/zero\"]]"};
  char *path = write_grid(f, "grid.asc", 499900, northing_m, "1 2 3\n4 5 6");
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  for (size_t i = 0; i < 2 * (sizeof systems / sizeof *systems); i++) {
    char *system = put_address(systems[i / 2], i % 2 ? l.address : l.url);
    desc.crs = system;
    test_log_clear(&f->log);
    assert_int_equal(load(f, path, &desc, &field), NEPH_ERROR_BAD_SCENE);
    assert_one_error(&f->log, "grid.asc: terrain.crs is \"", "must be a code, as EPSG:32611, or a text of WKT");
    free(system);
  }
  desc.crs = "+proj=utm +zone=11 +ellps=clrk66 +nadgrids=@null";
  assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
  np_heightfield_destroy(f->context, &field);
  assert_unheard(&l);
  close(l.socket);
  free(path);
}

static void pipes_and_devices_are_refused(void **state) {
  test_fixture *f = *state;
  static const char *const endings[] = {"tif", "asc", "vrt", "img", "bil", "dem", "dt0", "zip"};
  char name[20];
  for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
    (void)snprintf(name, sizeof name, "pipe.%s", endings[i]);
    char *path = test_path(f->folder, name);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_refused(f, path, "cannot be read: it is a device, a pipe or a socket");
    free(path);
  }
  char *path = write_grid(f, "grid.asc", 499900, northing_m, "1 2 3\n4 5 6");
  char *beside = test_path(f->folder, "grid.asc.aux.xml"), *projection = test_path(f->folder, "grid.prj");
  const neph_terrain_desc desc = describe_utm();
  np_heightfield field;
  assert_int_equal(mkfifo(beside, 0600) + mkfifo(projection, 0600), 0); /* neither is waited for */
  assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
  np_heightfield_destroy(f->context, &field);
  free(projection);
  free(beside);
  free(path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(files_outside_the_folder_are_refused),    TEST(files_below_the_folder_are_read),
      TEST(files_that_hang_on_a_raster_are_refused), TEST(systems_of_the_scene_open_nothing),
      TEST(pipes_and_devices_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
