# SPDX-License-Identifier: Apache-2.0
# Lists, reasons and errors are whole, however long: of AOVs, of clouds with long names, of wrong words.
nephos schema output.aovs | grep -c cryptomatte
nephos schema output.aovs --json | grep -c '"values": ".*cryptomatte.*"'
echo 'output: {aovs: [nothing]}' >wrong.yaml
nephos info wrong.yaml 2>&1 | tr , '\n' | grep -c '[a-z]' >listed
nephos schema output.aovs | sed -n 1p | tr , '\n' | grep -c '[a-z]' | cmp - listed
# Values and keys in messages
echo "version: 1" >right.yaml
word=$(printf "%0400d" 7)
nephos info right.yaml --set "sun.time=$word" 2>&1 | grep -c "sun.time is $word, must be"
nephos info right.yaml --set "sun.$word=1" 2>&1 | grep -c "sun.$word is not a key"
nephos info right.yaml --set "animate={sun.$word: [[1, 2]]}" 2>&1 | grep -c "sun.$word is not a key"
long=$(printf '%0200d' 0)
{
  echo 'clouds:'
  for i in 1 2 3; do echo "  - {name: c$i$long, bake: {extent: 1 km, voxel: 100 m}}"; done
} >long.yaml
nephos render long.yaml --explain | sed -n 's/^volumes  *yes  //p' | sed "s/$long/-/g; s/;  *[0-9.e+]* s.*//"
nephos render long.yaml --explain --json | grep -o "c[1-3]$long is baked" | sed "s/$long/-/"
