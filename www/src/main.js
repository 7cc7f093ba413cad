import { Failure, showFailure } from './failure.js';
import { checkBrowser, loadHead, loadModel, showLoading } from './loading.js';
import { chosenModel } from './models.js';

async function start() {
  checkBrowser();
  const chosen = chosenModel();
  const progress = showLoading();
  // three.js comes in and is compiled while the head does and is.
  const drawing = import('./stage.js');
  const head = chosen.head && (await loadHead(chosen.head));
  const { createStage } = await drawing;
  let stage = head && createStage(head);
  head?.free();
  // The head is on the screen before the model takes the line and the processor.
  if (stage) await new Promise((painted) => requestAnimationFrame(() => setTimeout(painted)));
  const designing = import('./designer.js');
  const model = await loadModel(chosen.url, stage ? stage.progress : progress);
  stage ??= createStage(model);
  const { createDesigner } = await designing;
  await createDesigner(model, stage, chosen);
}

start().catch((error) => {
  showFailure(error);
  // A failure that has no sentence of its own is a fault of the page: keep its trace.
  if (!(error instanceof Failure)) throw error;
});
