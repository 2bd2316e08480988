# SPDX-License-Identifier: Apache-2.0
# Control characters and bytes that are no UTF-8 are shown as '?', in results and in messages.
cat >scene.yaml <<'YAML'
camera: {resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
YAML
esc=$(printf '\033[31m') latin=$(printf '\351') c1=$(printf '\302\233') wide=$(printf 'caf\303\251')
line=$(printf 'a\nfake line.exr')
only_safe() { # input has no control but the line break, and is UTF-8
  tee text | iconv -f UTF-8 -t UTF-8 >/dev/null || echo 'not UTF-8'
  if LC_ALL=C grep -q "$(printf '[\001-\010\013-\037\177]')" text; then echo 'has controls'; fi
  cat text
}
for name in "$esc.exr" "$latin.exr" "$c1.exr" "$wide.exr" "$line"; do
  nephos render scene.yaml -n -o "$name" | only_safe
done
nephos render scene.yaml -q -o "$esc$latin.exr" | sed 's/,.*//' | only_safe
nephos info "$esc$latin.exr" | head -n 1 | only_safe
for word in "$esc" "$latin" "$c1" "$wide" "$line"; do
  nephos "$word" 2>&1 | only_safe
  nephos render scene.yaml -n -o "none/$word.exr" 2>&1 | only_safe
  nephos render scene.yaml --set "camera.$word=1" 2>&1 | cut -c1-60 | only_safe
done

# A header's values are lines of their own.
nephos render scene.yaml -q -o good.exr >log
LC_ALL=C sed "s/W m^-2 sr^-1 nm^-1/$esc$latin$(printf '\002')m^-2 !nm^-1/" good.exr | LC_ALL=C tr '!' '\n' >forged.exr
nephos info forged.exr | grep -A1 'unit' | only_safe
