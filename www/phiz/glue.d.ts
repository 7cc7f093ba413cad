declare module '*/phiz.js' {
  export * from 'phiz/raw';
  export { default } from 'phiz/raw';
}
