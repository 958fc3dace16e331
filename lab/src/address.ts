// State in the address: #widget?name=number&name=word, for the widget that was last changed. A query
// ?only=widget shows one experiment alone, for frames in other pages, and &theme=dark sets its colours.

export type Shared = Record<string, string | number>;

export interface Address {
  widget: string;
  values: URLSearchParams;
}

export function parseAddress(hash: string): Address {
  const [widget = '', query = ''] = hash.replace(/^#/, '').split('?', 2);
  return { widget, values: new URLSearchParams(query) };
}

export function formatAddress(widget: string, shared: Shared): string {
  const values = Object.entries(shared).map(([name, value]) => {
    // Seven digits: finer than any handle, and short.
    const text = typeof value === 'number' ? String(Number(value.toPrecision(7))) : value;
    return `${name}=${encodeURIComponent(text)}`;
  });
  return `#${widget}?${values.join('&')}`;
}

/** The experiment to show alone. */
export function aloneFrom(search: string): string | undefined {
  return new URLSearchParams(search).get('only') ?? undefined;
}

export function isAlone(): boolean {
  return aloneFrom(location.search) !== undefined;
}

/** The address that shows an experiment alone in that state. */
export function aloneAddress(page: string, widget: string, shared: Shared): string {
  const [place = ''] = page.split(/[?#]/, 1);
  return `${place}?only=${widget}${formatAddress(widget, shared)}`;
}

/** A finite number from the address, or the previous value. */
export function numberFrom(values: URLSearchParams, name: string, otherwise: number): number {
  const text = values.get(name);
  const value = Number(text);
  return text === null || text.trim() === '' || !Number.isFinite(value) ? otherwise : value;
}

/** A word from the address that is in the list. */
export function wordFrom<W extends string>(values: URLSearchParams, name: string, words: readonly W[], otherwise: W): W {
  const text = values.get(name);
  return words.find((word) => word === text) ?? otherwise;
}

/** Numbers with indexed names q0, q1, …; missing ones keep their value. */
export function numbersFrom(values: URLSearchParams, name: string, otherwise: ArrayLike<number>): Float64Array {
  return Float64Array.from(otherwise, (x, i) => numberFrom(values, `${name}${String(i)}`, x));
}

/** Writes such numbers. */
export function numbered(name: string, list: ArrayLike<number>): Shared {
  return Object.fromEntries(Array.from(list, (x, i) => [`${name}${String(i)}`, x]));
}

/** Largest number of characters that a link carries; some browsers and mail programs cut longer ones. */
export const LONGEST_PACKED = 24_000;

/** A text in characters that an address can contain: deflated, in base 64 without + / =. */
export async function pack(text: string): Promise<string> {
  const bytes = await through(new Blob([text]), new CompressionStream('deflate-raw'));
  let binary = '';
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return btoa(binary).replace(/\+/g, '-').replace(/\//g, '_').replace(/=+$/, '');
}

/** The text of [pack]; throws if it is invalid. */
export async function unpack(packed: string): Promise<string> {
  const binary = atob(packed.replace(/-/g, '+').replace(/_/g, '/'));
  const bytes = Uint8Array.from(binary, (letter) => letter.charCodeAt(0));
  return new TextDecoder().decode(await through(new Blob([bytes]), new DecompressionStream('deflate-raw')));
}

async function through(blob: Blob, transform: CompressionStream | DecompressionStream): Promise<Uint8Array> {
  return new Uint8Array(await new Response(blob.stream().pipeThrough(transform)).arrayBuffer());
}
