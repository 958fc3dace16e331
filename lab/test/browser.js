// A served page in headless Chromium; all errors and unexpected requests are recorded.
import { existsSync } from 'node:fs';
import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { extname, join, normalize } from 'node:path';

import { chromium } from 'playwright-core';

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm' };
const ROOT = new URL('../dist/site/', import.meta.url).pathname;

/** Serves the built site on a free port. */
export async function serve() {
  const server = createServer((request, response) => {
    const path = normalize(new URL(request.url, 'http://localhost').pathname);
    readFile(join(ROOT, path.endsWith('/') ? `${path}index.html` : path)).then(
      (body) => response.writeHead(200, { 'content-type': TYPES[extname(path)] ?? 'text/html' }).end(body),
      () => response.writeHead(404).end(),
    );
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return {
    address: `http://127.0.0.1:${server.address().port}/`,
    close: () => new Promise((resolve) => server.close(resolve)),
  };
}

/** Chromium, which not every system has in a headless build. */
const CHROMIUM = ['/usr/bin/chromium-headless-shell', '/usr/bin/chromium'].find((path) => existsSync(path));
let browser;

/** Runs before the page: hides from it that the processor draws, so that it draws as on a graphics card. */
export const asOnACard = () => {
  const get = WebGL2RenderingContext.prototype.getExtension;
  WebGL2RenderingContext.prototype.getExtension = function (name) {
    return name === 'WEBGL_debug_renderer_info' ? null : get.call(this, name);
  };
};

export async function openPage(address, { hash = '', clock = false, before, ready = 'html[data-ready]', ...context } = {}) {
  // WebGPU on the processor, which the page would reject as a graphics card.
  const args = ['--no-sandbox', '--enable-unsafe-swiftshader', '--enable-unsafe-webgpu'];
  browser ??= chromium.launch({ executablePath: CHROMIUM, args });
  const session = await (await browser).newContext({ viewport: { width: 1280, height: 900 }, ...context });
  const page = await session.newPage();
  const faults = [];
  page.on('console', (message) => {
    // Without a graphics card Chromium warns about reading pictures back.
    if (/GPU stall due to ReadPixels/.test(message.text())) return;
    if (['error', 'warning'].includes(message.type())) faults.push(`console: ${message.text()}`);
  });
  page.on('pageerror', (error) => faults.push(`page error: ${error.message}`));
  page.on('request', (request) => {
    const url = request.url();
    if (!url.startsWith(address) && !/^(data|blob|file):/.test(url)) faults.push(`left the page: ${url}`);
  });
  if (clock) await page.clock.install();
  if (before) await page.addInitScript(before);
  await page.goto(address + hash);
  await page.waitForSelector(ready);
  return { page, faults, close: () => session.close() };
}

export async function closeBrowser() {
  await (await browser)?.close();
}
