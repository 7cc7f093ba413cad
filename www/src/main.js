import { layGroundwork } from './groundwork/lay.js';
import { Failure, showFailure } from './frame/failure.js';
import { prepare } from 'phiz';
import { checkBrowser, loadHead, loadModel, showLoading } from './frame/loading.js';
import { chosenModel } from './frame/models.js';

const painted = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));

async function start() {
  checkBrowser();
  const chosen = chosenModel();
  const progress = showLoading();
  // three.js and the module come in and are compiled while the head does and is.
  const drawing = import('./stage/stage.js');
  prepare().catch(() => {}); // What loads a model says why it cannot.
  const groundwork = layGroundwork();
  const head = chosen.head && (await loadHead(chosen.head));
  const { createStage } = await drawing;
  let stage = head && createStage(head, groundwork);
  // The head is on the screen before the model takes the line and the processor.
  if (stage) await painted();
  const designing = import('./designer.js');
  const coming = loadModel(chosen.url, stage ? stage.progress : progress);
  // A failure is said where it is waited for.
  coming.catch(() => {});
  if (stage) {
    await stage.complete();
    head?.free();
    await painted();
  }
  const model = await coming;
  if (!stage) {
    stage = createStage(model, groundwork);
    await stage.complete();
  }
  const { createDesigner } = await designing;
  await createDesigner(model, stage, chosen);
}

start().catch((error) => {
  showFailure(error);
  // A failure that has no sentence of its own is a fault of the page: keep its trace.
  if (!(error instanceof Failure)) throw error;
});
