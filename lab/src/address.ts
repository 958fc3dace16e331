// State in the address: #widget?name=number&name=word. One widget at a time, the one last touched. Before it, ?only=widget is the
// experiment alone, for frames in other pages, and &theme=dark its colours.

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
    // Seven digits: finer than any handle, short enough to read.
    const text = typeof value === 'number' ? String(Number(value.toPrecision(7))) : value;
    return `${name}=${encodeURIComponent(text)}`;
  });
  return `#${widget}?${values.join('&')}`;
}

/** The experiment that the page is asked to show alone. */
export function aloneFrom(search: string): string | undefined {
  return new URLSearchParams(search).get('only') ?? undefined;
}

export function isAlone(): boolean {
  return aloneFrom(location.search) !== undefined;
}

/** Where an experiment stands alone, in that state. */
export function aloneAddress(page: string, widget: string, shared: Shared): string {
  const [place = ''] = page.split(/[?#]/, 1);
  return `${place}?only=${widget}${formatAddress(widget, shared)}`;
}

/** A finite number from the address, or what was there before. */
export function numberFrom(values: URLSearchParams, name: string, otherwise: number): number {
  const text = values.get(name);
  const value = Number(text);
  return text === null || text.trim() === '' || !Number.isFinite(value) ? otherwise : value;
}

/** One of a list of words from the address. */
export function wordFrom<W extends string>(values: URLSearchParams, name: string, words: readonly W[], otherwise: W): W {
  const text = values.get(name);
  return words.find((word) => word === text) ?? otherwise;
}

/** Numbers under one name and a count: q0, q1, …; what is missing stays as it was. */
export function numbersFrom(values: URLSearchParams, name: string, otherwise: ArrayLike<number>): Float64Array {
  return Float64Array.from(otherwise, (x, i) => numberFrom(values, `${name}${String(i)}`, x));
}

/** The same the other way. */
export function numbered(name: string, list: ArrayLike<number>): Shared {
  return Object.fromEntries(Array.from(list, (x, i) => [`${name}${String(i)}`, x]));
}

/** The longest text that a link carries, in characters: more than this some browsers and mail programs cut off. */
export const LONGEST_PACKED = 24_000;

/** A text as letters that an address can carry: deflated, in base 64 without + / =. */
export async function pack(text: string): Promise<string> {
  const bytes = await through(new Blob([text]), new CompressionStream('deflate-raw'));
  let binary = '';
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return btoa(binary).replace(/\+/g, '-').replace(/\//g, '_').replace(/=+$/, '');
}

/** The text of [pack]; refuses what is none. */
export async function unpack(packed: string): Promise<string> {
  const binary = atob(packed.replace(/-/g, '+').replace(/_/g, '/'));
  const bytes = Uint8Array.from(binary, (letter) => letter.charCodeAt(0));
  return new TextDecoder().decode(await through(new Blob([bytes]), new DecompressionStream('deflate-raw')));
}

async function through(blob: Blob, transform: CompressionStream | DecompressionStream): Promise<Uint8Array> {
  return new Uint8Array(await new Response(blob.stream().pipeThrough(transform)).arrayBuffer());
}
