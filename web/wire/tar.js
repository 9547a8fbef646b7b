const block = 512;

/// A POSIX tar archive (ustar) of files {name, parts}, parts as a Blob takes them.
export function make_tar(files) {
  const parts = files.flatMap(({name, parts: content}) => {
    const blob = new Blob(content);
    return [header(name, blob.size), blob, new Uint8Array((block - blob.size % block) % block)];
  });
  return new Blob([...parts, new Uint8Array(2 * block)], {type: 'application/x-tar'});
}

function header(name, size) {
  const bytes = new Uint8Array(block);
  const put = (text, at) => bytes.set(new TextEncoder().encode(text), at);
  const octal = (value, digits) => `${value.toString(8).padStart(digits, '0')}\0`;
  put(name.slice(0, 99), 0);
  put(octal(0o644, 7), 100);
  put(octal(0, 7), 108);
  put(octal(0, 7), 116);
  put(octal(size, 11), 124);
  put(octal(0, 11), 136);
  put(' '.repeat(8), 148);  // the checksum counts itself as spaces
  put('0ustar\0' + '00', 156);
  put(`${bytes.reduce((sum, byte) => sum + byte, 0).toString(8).padStart(6, '0')}\0 `, 148);
  return bytes;
}
