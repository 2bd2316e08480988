# SPDX-License-Identifier: Apache-2.0
# Sourced by the farms' tests.

# put_failing_program TASK: a nephos in $PATH, of the folder $work, which fails for the first time that it renders TASK, a
# part of its command line.
put_failing_program() {
  mkdir "$work/bin"
  cat >"$work/bin/nephos" <<PROGRAM
#!/bin/sh
case "\$*" in
  *"render"*"$1"*) [ -e "$work/failed" ] || { : >"$work/failed"; echo "made to fail" >&2; exit 5; } ;;
esac
exec "$program" "\$@"
PROGRAM
  chmod +x "$work/bin/nephos"
  PATH=$work/bin:$PATH
  export PATH
}
