import { paintStrands } from '../hair/tile.js';
import { paintLines } from './lines.js';

addEventListener('message', ({ data: landmarks }) => {
  const lines = paintLines(landmarks);
  postMessage({ lines }, { transfer: [lines.map.rgba.buffer] });
  const strands = paintStrands();
  postMessage({ strands }, { transfer: [strands.rgba.buffer] });
});
