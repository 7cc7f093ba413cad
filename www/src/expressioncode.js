// An expression in the page's address: for each that is shown its place in the list and its weight
// in per cent, a byte each, as base64url.

/** @param {readonly string[]} names @param {Record<string, number>} expression @returns {string} empty at rest */
export function encodeExpression(names, expression) {
  const bytes = names.flatMap((name, i) => {
    const percent = Math.round(100 * (expression[name] ?? 0));
    return percent > 0 ? [i, percent] : [];
  });
  return btoa(String.fromCharCode(...bytes)).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '');
}

/**
 * @param {readonly string[]} names @param {string} code
 * @returns {Record<string, number>}
 * @throws when it is no expression
 */
export function decodeExpression(names, code) {
  const bytes = atob(code.replaceAll('-', '+').replaceAll('_', '/'));
  if (bytes.length % 2) throw new Error('it is cut short');
  /** @type {Record<string, number>} */
  const expression = {};
  for (let at = 0; at < bytes.length; at += 2) {
    const [i, percent] = [bytes.charCodeAt(at), bytes.charCodeAt(at + 1)];
    if (i >= names.length || percent > 100) throw new Error('it has an expression that is not there');
    expression[names[i]] = percent / 100;
  }
  return expression;
}

/** What the address has after the #: a face and, after a tilde, an expression. @param {string} hash */
export function splitHash(hash) {
  const [code, expression = ''] = hash.replace(/^#/, '').split('~');
  return { code, expression };
}
