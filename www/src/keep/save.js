/**
 * A name of a face as a name of a file.
 * @param {string} name @param {string} ending
 */
export function fileName(name, ending) {
  return `${name.normalize('NFC').replaceAll(/[^\p{L}\p{M}\p{N}]+/gu, '-').replaceAll(/^-|-$/g, '').toLowerCase() || 'face'}.${ending}`;
}

/**
 * Hands a file to the person, as a download.
 * @param {Blob} blob @param {string} name
 */
export function save(blob, name) {
  const url = URL.createObjectURL(blob);
  const link = document.createElement('a');
  link.href = url;
  link.download = name;
  link.click();
  // The download has started with the click; a minute is for browsers that ask first.
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}
