# Sourced by server/run and tests/run: installs what is missing and builds. All output goes to stderr.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '%s\n' "$*" >&2; }
fail() { say "error: $*"; exit 1; }

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else fail "installing packages needs root or sudo: $*"
  fi
}

# install_packages LIST…: each line of a list is a Debian package and, optionally, a command that stands for it.
install_packages() {
  local missing=() package command
  while read -r package command; do
    case "$package" in ''|'#'*) continue ;; esac
    [ -n "$command" ] && command -v "$command" >/dev/null && continue
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done < <(cat "$@")
  [ ${#missing[@]} -gt 0 ] || return 0
  say "installing ${missing[*]}"
  as_root apt-get update -q >&2
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -q --no-install-recommends "${missing[@]}" >&2
}

# install_npm FOLDER: what its package-lock.json names, unless it is there already.
install_npm() {
  local folder=$root/$1
  [ "$folder/node_modules/.package-lock.json" -nt "$folder/package-lock.json" ] && return 0
  say "installing npm packages of $1"
  npm ci --prefix "$folder" --ignore-scripts --no-audit --no-fund >&2
  touch "$folder/node_modules/.package-lock.json"
}

# build PRESET [TARGET…]
build() {
  local preset=$1; shift
  (
    cd "$root"
    if [ ! -f "build/$preset/build.ninja" ] || [ CMakePresets.json -nt "build/$preset/build.ninja" ]; then
      cmake --preset "$preset" >&2
      touch "build/$preset/build.ninja"
    fi
    cmake --build "build/$preset" ${1:+--target "$@"} >&2
  )
}
