// equations.tex becomes MathML by name when the page is built; see build/equations.ts.
declare module '*.tex' {
  const mathml: Record<string, string>;
  export default mathml;
}
