/**
 * Lets a row that scrolls sideways fade where it goes on, so that one sees that it does.
 * @template {HTMLElement} T
 * @param {T} row
 * @param {() => HTMLElement | undefined} [chosen] what of it is to be seen whenever it is laid out
 */
export function fading(row, chosen = () => undefined) {
  function look() {
    row.classList.toggle('goes-before', row.scrollLeft > 1);
    row.classList.toggle('goes-on', row.scrollLeft + row.clientWidth < row.scrollWidth - 1);
  }
  row.classList.add('fading');
  row.addEventListener('scroll', look, { passive: true });
  // Larger letters make what is in it wider, and not the row.
  const observer = new ResizeObserver(() => {
    reveal(chosen());
    look();
  });
  for (const each of [row, ...row.children]) observer.observe(each);
  return row;
}

/**
 * Brings a part of a row that scrolls sideways to its middle, as far as the row goes.
 * @param {HTMLElement} [part]
 */
export function reveal(part) {
  const row = part?.parentElement;
  if (!part || !row) return;
  const [inner, outer] = [part.getBoundingClientRect(), row.getBoundingClientRect()];
  row.scrollLeft += (inner.left + inner.right - outer.left - outer.right) / 2;
}
