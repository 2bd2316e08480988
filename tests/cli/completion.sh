# SPDX-License-Identifier: Apache-2.0
# Completion in a real bash, on a terminal: each line below is typed, and the words are printed that bash then has.
mkdir folder
touch scene.yaml frame.exr frame.png cases.csv notes.txt folder/deep.yaml
nephos help --completion bash >nephos.bash
bash -n nephos.bash
cat >lines <<'LINES'
nephos ren\t
nephos render --integ\tpa\tsc\t
nephos render --integrator=ma\t
nephos render --path-guiding \tadj\t
nephos probe --path-guiding au\tsl\tca\t
nephos render fo\tde\t
nephos render scene.yaml -o frame.e\t
nephos render --set camera.ro\t30
nephos bake --set clouds[0].bake.vox\t
nephos --isa x86-64-v4 compare fra\t
nephos info no\t
nephos sky scene.yaml --tables fo\t
nephos schema atmosphere.oz\tce\t
nephos help com\t
nephos help --completion f\t
nephos render --samples \t4 --see\t
LINES
python3 - lines <<'PYTHON'
import os, pty, select, sys, time

pid, terminal = pty.fork()
if pid == 0:
    os.environ.update(PS1='', TERM='dumb', INPUTRC='/dev/null', HISTFILE='')
    os.execvp('bash', ['bash', '--norc', '--noprofile', '-i'])


def read_until(mark):
    text = b''
    end = time.time() + 30
    while mark not in text and time.time() < end:
        if select.select([terminal], [], [], 0.1)[0]:
            text += os.read(terminal, 65536)
    return text.decode()


def send(text):
    os.write(terminal, text.encode())


send('bind "set bell-style none"; bind "set enable-bracketed-paste off"; source nephos.bash\n')
send('nephos() { printf "<%s> " "$@"; printf "@%s\\n" @; }\n')
send('nephos\n')
read_until(b'@@')
for line in open(sys.argv[1]):
    for key in line.rstrip('\n').replace('\\t', '\t'):
        send(key)
    send('\n')
    words = [w for w in read_until(b'@@').splitlines() if w.endswith(' @@')]
    print(line.rstrip('\n'), '->', words[-1][:-3] if words else 'nothing')
send('exit\n')
PYTHON
# Other shells, where there are any.
nephos help --completion fish >nephos.fish
nephos help --completion zsh >_nephos
if command -v fish >/dev/null; then
  [ "$(fish -c 'source nephos.fish; complete -C "nephos ren"' | cut -f1)" = render ]
  [ "$(fish -c 'source nephos.fish; complete -C "nephos probe slab --path-guiding au"' | cut -f1)" = auto ]
fi
if command -v zsh >/dev/null; then zsh -n _nephos; fi
