#!/bin/sh
# Look for the system libraries that conf needs. Install what is missing with apt where that is allowed,
# otherwise print the one line to type. With --test: what the tests need as well.
set -u

packages=""
need() { # need PACKAGE TEST...: note the package when the test fails
    package=$1
    shift
    "$@" >/dev/null 2>&1 || packages="$packages $package"
}

library() { ldconfig -p 2>/dev/null | grep -q "$1" || /sbin/ldconfig -p 2>/dev/null | grep -q "$1"; }
driver() { find /usr/lib /usr/lib64 -name '*_dri.so' 2>/dev/null | grep -q . || library libgallium; }

need libgl1 library libGL.so.1
need libegl1 library libEGL.so.1
need libx11-6 library libX11.so.6
need libgl1-mesa-dri driver
need python3-venv "${PYTHON:-python3}" -c 'import venv, ensurepip'
if [ "${1:-}" = "--test" ]; then
    need xvfb command -v Xvfb
    need xdotool command -v xdotool
fi
[ -z "$packages" ] && exit 0

line="apt-get install -y --no-install-recommends$packages"
if ! command -v apt-get >/dev/null 2>&1; then
    echo "conf needs these libraries, by their Debian names:$packages" >&2
    exit 1
elif [ "$(id -u)" = 0 ]; then
    run=""
elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    run="sudo"
else
    echo "conf needs system libraries; type:  sudo $line" >&2
    exit 1
fi
echo "installing:$packages"
log=$(mktemp)
if ! { $run apt-get update -qq && DEBIAN_FRONTEND=noninteractive $run $line; } >"$log" 2>&1; then
    tail -5 "$log" >&2
    echo "that did not work; type:  sudo $line" >&2
    exit 1
fi
rm -f "$log"
