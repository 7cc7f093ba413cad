interface Window {
  /** For automation: the model and the face on the page. */
  designer: { model: import('phiz').FaceModel; face: import('phiz').Face };
}
