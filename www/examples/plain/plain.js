// What a page does with the element: listen, call, and nothing else.
const designer = document.querySelector('phiz-designer');
const code = document.querySelector('#code');
const random = document.querySelector('#random');
const picture = document.querySelector('#picture');

function begin() {
  code.value = designer.code;
  random.disabled = picture.disabled = false;
}
designer.addEventListener('ready', begin);
// It may have been ready before this script came.
if (designer.model) begin();
designer.addEventListener('change', (event) => {
  code.value = event.detail.code;
});
designer.addEventListener('error', (event) => {
  code.value = event.detail.message;
});
random.addEventListener('click', () => designer.randomize());
picture.addEventListener('click', async () => {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(await designer.toPng({ width: 1200, height: 1200, transparent: true }));
  link.download = 'face.png';
  link.click();
  // Not before the browser has begun to read it.
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
});
