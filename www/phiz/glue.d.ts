declare module '*/phiz.js' {
  export * from 'phiz/raw';
  export { default } from 'phiz/raw';
}
declare module '*/photo.js' {
  export * from 'phiz/raw-photo';
  export { default } from 'phiz/raw-photo';
}
