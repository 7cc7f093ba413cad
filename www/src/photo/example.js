import { Failure } from '../frame/failure.js';
import { text } from '../text.js';

/** What the example's portrait is called. */
export const EXAMPLE = 'astronaut.jpg';

export async function fetchExample() {
  try {
    const response = await fetch(new URL(EXAMPLE, document.baseURI));
    if (!response.ok) throw new Error(String(response.status));
    return await response.blob();
  } catch (error) {
    throw new Failure(text.photo.noExample(error instanceof Error ? error.message : String(error)));
  }
}
