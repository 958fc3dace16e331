// Types of the used part of a package without types.
declare module 'subset-font' {
  /** A font with only the characters of that text. */
  interface Options { targetFormat: 'woff2'; noHinting: boolean }
  export default function subsetFont(font: Uint8Array, text: string, options: Options): Promise<Uint8Array>;
}
