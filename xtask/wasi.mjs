// Runs a program compiled for wasm32-wasip1 with the rights of a native one: node xtask/wasi.mjs PROGRAM.wasm
// [ARGUMENT…]
import { readFile } from 'node:fs/promises';
import { env, argv, exit } from 'node:process';
import { WASI } from 'node:wasi';

const wasi = new WASI({ version: 'preview1', args: argv.slice(2), env, preopens: { '/': '/' } });
const module = await WebAssembly.compile(await readFile(argv[2]));
exit(wasi.start(await WebAssembly.instantiate(module, wasi.getImportObject())));
