/**
 * Whether a file is a picture as far as the browser knows, which says nothing of kinds that are strange to it, as HEIC is to most.
 * @param {File} file
 */
export const mayBePicture = ({ name, type }) => type.startsWith('image/') || (type === '' && !/\.json$/i.test(name));
