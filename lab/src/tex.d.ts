// equations.tex becomes MathML by name at build time; see build/equations.ts.
declare module '*.tex' {
  const mathml: Record<string, string>;
  export default mathml;
}
