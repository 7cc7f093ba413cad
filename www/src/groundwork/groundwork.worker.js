import { headWork, studioWork } from './groundwork.js';

// The studio's is begun before there is a head.
postMessage(studioWork());
addEventListener('message', ({ data }) => postMessage(headWork(data)));
