/* SPDX-License-Identifier: Apache-2.0 */
/* Mattes by cloud, Cryptomatte and holdouts, in both integrators. */
#include "core/json.h"
#include "test_layers.h"

/* Sums of floats of the size of the layers. */
static const double rounding = 2e-6;

/* ---- Mattes ---- */

/* A pixel is covered by the clouds and the ground alone. */
static void mattes_add_up_to_the_coverage(void **state) {
  fixture *f = *state;
  static const char *const methods[] = {"ordinates", "octaves", "ordinates"};
  for (int i = 0; i < 3; i++) {
    set(f, "render.multiple_scattering", methods[i]);
    neph_image *image = render_layers(f, integrators[i / 2], "[mattes, clouds]");
    double most[3] = {0.0, 0.0, 0.0};
    for (size_t p = 0; p < count_pixels(image); p++) {
      const double mattes[3] = {get_value(image, "matte.left", p), get_value(image, "matte.right", p),
                                get_value(image, "matte.ground", p)};
      for (int m = 0; m < 3; m++) most[m] = fmax(most[m], mattes[m]);
      /* 0.001: the march ends rays below this by Russian roulette. */
      assert_near(mattes[0] + mattes[1], get_value(image, "clouds.A", p), i < 2 ? 1e-3 : rounding);
      assert_near(mattes[0] + mattes[1] + mattes[2], get_value(image, "A", p), i < 2 ? 1e-3 : rounding);
    }
    for (int m = 0; m < 3; m++) assert_true(most[m] > 0.9);
    neph_image_destroy(image);
  }
  set(f, "render.multiple_scattering", "ordinates");
}

/* ---- Cryptomatte ---- */

/* Values of the reference implementation (Appleby's SMHasher). */
static void hashes_are_murmurs(void **state) {
  (void)state;
  assert_int_equal(np_murmur_hash(""), 0);
  assert_int_equal(np_murmur_hash("hello"), 0x248bfa47);
  assert_int_equal(np_murmur_hash("hello, world"), 0x149bbb7f);
  assert_int_equal(np_murmur_hash("The quick brown fox jumps over the lazy dog"), 0x2e4ff723);
}

/* Whatever the name: a file's float keeps it to the bit. */
static void identifiers_are_normal_numbers(void **state) {
  (void)state;
  for (int i = 0; i < 5000; i++) {
    char name[16];
    (void)snprintf(name, sizeof name, "cloud%d", i);
    assert_true(isnormal(np_cryptomatte_get_id(name)));
  }
}

static void check_ranks(const neph_image *image, size_t pixel) {
  double last = HUGE_VAL;
  for (unsigned rank = 0; rank < NP_CRYPTOMATTE_RANKS; rank++) {
    char name[32];
    np_cryptomatte_name_channel(2 * rank + 1, name, sizeof name);
    assert_true(get_value(image, name, pixel) <= last);
    last = get_value(image, name, pixel);
  }
}

static void ranks_hold_the_mattes(void **state) {
  fixture *f = *state;
  static const char *const names[] = {"left", "right", "ground"};
  for (int i = 0; i < 2; i++) {
    neph_image *mattes = render_layers(f, integrators[i], "[mattes]");
    neph_image *image = render_layers(f, integrators[i], "[cryptomatte]");
    assert_null(neph_image_get_values(image, "matte.left"));
    for (size_t p = 0; p < count_pixels(image); p++) {
      check_ranks(image, p);
      for (int m = 0; m < 3; m++) {
        char name[16];
        (void)snprintf(name, sizeof name, "matte.%s", names[m]);
        assert_near(get_coverage(image, np_cryptomatte_get_id(names[m]), p), get_value(mattes, name, p), 0.0);
      }
    }
    neph_image_destroy(mattes);
    neph_image_destroy(image);
  }
}

static const char *get_metadata(const neph_image *image, const char *name) {
  char key[64], hash[9];
  (void)snprintf(hash, sizeof hash, "%08x", np_murmur_hash("CryptoObject"));
  (void)snprintf(key, sizeof key, "cryptomatte/%.7s/%s", hash, name);
  const char *value = neph_image_get_attribute(image, key);
  return value ? value : "";
}

static void header_has_the_manifest(void **state) {
  fixture *f = *state;
  neph_image *image = render_layers(f, "march", "[cryptomatte]");
  assert_string_equal(get_metadata(image, "name"), "CryptoObject");
  assert_string_equal(get_metadata(image, "hash"), "MurmurHash3_32");
  assert_string_equal(get_metadata(image, "conversion"), "uint32_to_float32");
  np_json_value *manifest = np_json_read(get_metadata(image, "manifest"));
  const char *left = np_json_get_text(manifest, "left");
  assert_non_null(left);
  const uint32_t bits = (uint32_t)strtoul(left, NULL, 16);
  float id;
  memcpy(&id, &bits, sizeof id);
  assert_true(id == np_cryptomatte_get_id("left"));
  assert_non_null(np_json_get_text(manifest, "ground"));
  np_json_value_destroy(manifest);
  neph_image_destroy(image);
}

/* ---- Holdouts ---- */

static void hold_out(fixture *f, bool left, bool right, bool ground) {
  set(f, "clouds[0].holdout", left ? "true" : "false");
  set(f, "clouds[1].holdout", right ? "true" : "false");
  set(f, "terrain.holdout", ground ? "true" : "false");
}

/* Pictures in each of which all but one is held out add up: to the bit of rounding in the march, whose rays do not
 * change; paths behind thin cloud go elsewhere, so that of their colours the means agree, to 3 % with this noise. */
static void what_is_held_out_hides_and_does_not_show(void **state) {
  fixture *f = *state;
  static const char *const channels[] = {"R", "G", "B", "A"};
  for (int i = 0; i < 2; i++) {
    neph_image *parts[3], *whole = render_layers(f, integrators[i], "[transmittance]");
    for (int n = 0; n < 3; n++) {
      hold_out(f, n != 0, n != 1, n != 2);
      set(f, "output.film.background", n == 2 ? "true" : "false");
      parts[n] = render_layers(f, integrators[i], "[transmittance, mattes]");
    }
    hold_out(f, false, false, false);
    for (int c = 0; c < 4; c++) {
      double sum = 0.0;
      for (int n = 0; n < 3; n++) sum += get_mean(parts[n], channels[c]);
      assert_near_relative(sum, get_mean(whole, channels[c]), i == 1 && c < 3 ? 0.03 : 1e-5);
      for (size_t p = 0; p < count_pixels(whole) && (i == 0 || c == 3); p++) {
        sum = 0.0;
        for (int n = 0; n < 3; n++) sum += get_value(parts[n], channels[c], p);
        /* In A, 0.003: what the march's Russian roulette leaves of three rays. */
        assert_near(sum, get_value(whole, channels[c], p), c == 3 ? 3e-3 : 1e-5);
      }
    }
    for (size_t p = 0; p < count_pixels(whole); p++) {
      assert_near(get_value(parts[0], "transmittance", p), get_value(whole, "transmittance", p), 0.0);
      assert_near(get_value(parts[0], "matte.right", p) + get_value(parts[0], "matte.ground", p), 0.0, 0.0);
    }
    for (int n = 0; n < 3; n++) neph_image_destroy(parts[n]);
    neph_image_destroy(whole);
  }
}

/* The sun is behind the camera's right: the shadow of a cloud that does not show stays. */
static void what_is_held_out_still_shades(void **state) {
  fixture *f = *state;
  set(f, "camera.position", "[-2000 m, -3 km, 3000 m]");
  set(f, "camera.look_at", "[-1000 m, 500 m, 100 m]");
  for (int i = 0; i < 2; i++) {
    neph_image *whole = render_layers(f, integrators[i], "[shadow]");
    hold_out(f, true, true, false);
    neph_image *held = render_layers(f, integrators[i], "[shadow, mattes]");
    hold_out(f, false, false, false);
    double least = 1.0;
    for (size_t p = 0; p < count_pixels(held); p++)
      if (get_value(held, "matte.ground", p) == 1.0) {
        assert_near(get_value(held, "shadow", p), get_value(whole, "shadow", p), 1e-6);
        least = fmin(least, get_value(held, "shadow", p));
      }
    assert_true(least < 0.5);
    neph_image_destroy(whole);
    neph_image_destroy(held);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(mattes_add_up_to_the_coverage),  cmocka_unit_test(hashes_are_murmurs),
      cmocka_unit_test(identifiers_are_normal_numbers), cmocka_unit_test(ranks_hold_the_mattes),
      cmocka_unit_test(header_has_the_manifest),        cmocka_unit_test(what_is_held_out_hides_and_does_not_show),
      cmocka_unit_test(what_is_held_out_still_shades),
  };
  return cmocka_run_group_tests(tests, set_up_layers, tear_down);
}
