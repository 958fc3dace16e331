import tseslint from 'typescript-eslint';

export default tseslint.config(
  { ignores: ['dist', 'generated', 'wasm', 'node_modules', 'screenshots'] },
  ...tseslint.configs.strict,
  {
    rules: {
      // Lists from Rust have known layouts.
      '@typescript-eslint/no-non-null-assertion': 'off',
      'max-len': ['error', { code: 140, ignoreUrls: true }],
      'max-lines': ['error', { max: 300, skipComments: true }],
      eqeqeq: 'error',
      'prefer-const': 'error',
    },
  },
);
