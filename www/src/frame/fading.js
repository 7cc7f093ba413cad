/**
 * Lets a row that scrolls sideways fade where it goes on, so that one sees that it does.
 * @template {HTMLElement} T
 * @param {T} row
 */
export function fading(row) {
  function look() {
    row.classList.toggle('goes-before', row.scrollLeft > 1);
    row.classList.toggle('goes-on', row.scrollLeft + row.clientWidth < row.scrollWidth - 1);
  }
  row.classList.add('fading');
  row.addEventListener('scroll', look, { passive: true });
  new ResizeObserver(look).observe(row);
  return row;
}
