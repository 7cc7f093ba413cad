import { headWork, studioWork } from './groundwork.js';

// One of two: what is the same for every head, or a head's own.
addEventListener('message', ({ data: { rest } }) => postMessage(rest ? headWork(rest) : studioWork()));
