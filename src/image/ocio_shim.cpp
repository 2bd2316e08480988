/* SPDX-License-Identifier: Apache-2.0 */
/* OpenColorIO behind C functions. No exception leaves this file.
 *
 * Light comes with the primaries of Rec.709. Configurations name their spaces as they like; the roles aces_interchange
 * and cie_xyz_d65_interchange of OpenColorIO 2 say how a known space joins them. Without a role the names that linear
 * Rec.709 has in the configurations of ACES and Blender are tried. */
#include "image/ocio_table.h"

#include <filesystem>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>

#include <OpenColorIO/OpenColorIO.h>

namespace OCIO = OCIO_NAMESPACE;

struct np_ocio_transform {
  OCIO::ConstCPUProcessorRcPtr processor;
};

namespace {

/* A fault of the description, not of the file. */
struct BadArgument : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/* ---- Configurations ---- */

/* The configuration that was opened last, kept as long as its file stays the same. */
struct Kept {
  std::mutex lock;
  std::string path;
  std::filesystem::file_time_type time;
  OCIO::ConstConfigRcPtr config;
};

OCIO::ConstConfigRcPtr get_config(const char *path) {
  static Kept kept;
  std::error_code error;
  const auto time = std::filesystem::last_write_time(path, error);
  const std::lock_guard<std::mutex> guard(kept.lock);
  if (!kept.config || kept.path != path || kept.time != time) {
    kept.config = OCIO::Config::CreateFromFile(path);
    kept.path = path, kept.time = time;
  }
  return kept.config;
}

/* ---- Displays and views ---- */

/* A name among `count` ones that `get` returns. The message of a missing one lists them. */
template <class Get> void check_name(const char *name, const char *what, int count, Get get) {
  std::string names;
  for (int i = 0; i < count; i++) {
    if (!std::string(get(i)).compare(name)) return;
    names += std::string(i ? ", " : "") + get(i);
  }
  throw BadArgument(std::string(what) + " is " + name + ", must be one of: " + names);
}

std::string choose_display(const OCIO::ConstConfigRcPtr &config, const np_ocio_source &source) {
  if (!source.display) return config->getDefaultDisplay();
  check_name(source.display, "display", config->getNumDisplays(), [&](int i) { return config->getDisplay(i); });
  return source.display;
}

std::string choose_view(const OCIO::ConstConfigRcPtr &config, const np_ocio_source &source, const char *display) {
  if (!source.view) return config->getDefaultView(display);
  check_name(source.view, "view", config->getNumViews(display), [&](int i) { return config->getView(display, i); });
  return source.view;
}

/* ---- The way to a space of the configuration ---- */

/* Rec.709's primaries to CIE 1931 X, Y, Z of the white D65, IEC 61966-2-1. */
OCIO::TransformRcPtr make_xyz_from_rec709() {
  static const double matrix[16] = {0.4123908, 0.3575843, 0.1804808, 0, 0.2126390, 0.7151687, 0.0721923, 0,
                                    0.0193308, 0.1191948, 0.9505322, 0, 0,         0,         0,         1};
  OCIO::MatrixTransformRcPtr made = OCIO::MatrixTransform::Create();
  made->setMatrix(matrix);
  return made;
}

OCIO::TransformRcPtr make_aces_from_xyz() {
  OCIO::BuiltinTransformRcPtr made = OCIO::BuiltinTransform::Create();
  made->setStyle("UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD");
  made->setDirection(OCIO::TRANSFORM_DIR_INVERSE);
  return made;
}

const char *search_rec709(const OCIO::ConstConfigRcPtr &config) {
  static const char *const names[] = {"lin_rec709",
                                      "lin_rec709_scene",
                                      "lin_srgb",
                                      "Linear Rec.709 (sRGB)",
                                      "Linear Rec.709",
                                      "Linear BT.709",
                                      "Utility - Linear - sRGB",
                                      "Utility - Linear - Rec.709"};
  for (const char *name : names)
    if (config->getColorSpace(name)) return name;
  return nullptr;
}

/* Appends what leads from Rec.709 to a space of the configuration, and returns its name. */
std::string append_way(const OCIO::ConstConfigRcPtr &config, const char *input, OCIO::GroupTransform &group) {
  if (input) {
    check_name(input, "input", config->getNumColorSpaces(), [&](int i) { return config->getColorSpaceNameByIndex(i); });
    return input;
  }
  const bool is_aces = config->hasRole(OCIO::ROLE_INTERCHANGE_SCENE);
  if (is_aces || config->hasRole(OCIO::ROLE_INTERCHANGE_DISPLAY)) {
    group.appendTransform(make_xyz_from_rec709());
    if (is_aces) group.appendTransform(make_aces_from_xyz());
    return is_aces ? OCIO::ROLE_INTERCHANGE_SCENE : OCIO::ROLE_INTERCHANGE_DISPLAY;
  }
  if (const char *name = search_rec709(config)) return name;
  throw BadArgument("the configuration has no role aces_interchange: input must name its space of linear light with "
                    "the primaries of Rec.709");
}

/* ---- The table ---- */

OCIO::ConstCPUProcessorRcPtr make_processor(const np_ocio_source &source) {
  const OCIO::ConstConfigRcPtr config = get_config(source.config);
  const std::string display = choose_display(config, source);
  OCIO::GroupTransformRcPtr group = OCIO::GroupTransform::Create();
  OCIO::DisplayViewTransformRcPtr shown = OCIO::DisplayViewTransform::Create();
  shown->setSrc(append_way(config, source.input, *group).c_str());
  shown->setDisplay(display.c_str());
  shown->setView(choose_view(config, source, display.c_str()).c_str());
  group->appendTransform(shown);
  return config->getProcessor(group)->getDefaultCPUProcessor();
}

/* One line of what an exception says. */
std::string flatten(const char *text) {
  std::string line;
  for (; *text; text++)
    if (*text != '\n' && *text != '\r')
      line += *text;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

np_ocio_transform *open_transform(const np_ocio_source *source, const np_ocio_listener *listener) noexcept {
  try {
    return new np_ocio_transform{make_processor(*source)};
  } catch (const std::bad_alloc &) {
    listener->fail(listener->user, NEPH_ERROR_OUT_OF_MEMORY, "out of memory");
  } catch (const BadArgument &fault) {
    listener->fail(listener->user, NEPH_ERROR_INVALID_ARGUMENT, fault.what());
  } catch (const std::exception &fault) {
    listener->fail(listener->user, NEPH_ERROR_BAD_FILE, flatten(fault.what()).c_str());
  } catch (...) {
    listener->fail(listener->user, NEPH_ERROR_BAD_FILE, "OpenColorIO cannot use it");
  }
  return nullptr;
}

void close_transform(np_ocio_transform *transform) noexcept { delete transform; }

void map_pixel(const np_ocio_transform *transform, float rgb[3]) noexcept { transform->processor->applyRGB(rgb); }

} /* namespace */

const np_ocio_module *nephos_ocio_module(void) {
  static const np_ocio_module table = {NP_OCIO_MODULE_VERSION, open_transform, close_transform, map_pixel};
  return &table;
}
