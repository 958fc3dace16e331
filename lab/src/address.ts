// State in the address: #widget?name=number&name=word. One widget at a time, the one last touched.

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
    // Six digits: finer than any handle, short enough to read.
    const text = typeof value === 'number' ? String(Number(value.toPrecision(7))) : value;
    return `${name}=${encodeURIComponent(text)}`;
  });
  return `#${widget}?${values.join('&')}`;
}

/** A finite number from the address, or what was there before. */
export function numberFrom(values: URLSearchParams, name: string, otherwise: number): number {
  const text = values.get(name);
  const value = Number(text);
  return text === null || text.trim() === '' || !Number.isFinite(value) ? otherwise : value;
}

/** One of a list of words from the address. */
export function wordFrom<W extends string>(
  values: URLSearchParams,
  name: string,
  words: readonly W[],
  otherwise: W,
): W {
  const text = values.get(name);
  return words.find((word) => word === text) ?? otherwise;
}
