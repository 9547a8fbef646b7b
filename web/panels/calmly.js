const pause = 250;  // milliseconds

/// While previews follow each other the picture goes first: what changes in a panel is then written a little later, once
/// for all of them.
export function calmly(meshing, write) {
  let later = null;
  const now = () => {
    clearTimeout(later);
    later = null;
    write();
  };
  return () => {
    if (!meshing.previewing) return now();
    later ??= setTimeout(() => {
      later = null;
      if (meshing.model) write();
    }, pause);
  };
}
