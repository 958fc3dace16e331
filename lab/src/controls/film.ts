// A video of a picture, recorded by the browser.
import { button } from './choice.ts';
import { download } from '../drawing/plot-group.ts';

/** Video formats; the first supported one is used. */
const KINDS = [['video/webm', 'webm'], ['video/mp4', 'mp4']] as const;
const RATE = 60;

export interface Film {
  /** The canvas to record, from now on, or null. */
  begin: () => HTMLCanvasElement | null;
  /** Called when recording ends. */
  end?: () => void;
  /** Base name of the file. */
  name: () => string;
  /** Text of the button. */
  title: string;
  kind?: string;
}

/** A button that records a canvas until it is pressed again and then saves the file. It is hidden if the
 * browser cannot record. */
export function filmButton({ begin, end, name, title, kind: style = '' }: Film): HTMLButtonElement {
  const kind = 'MediaRecorder' in globalThis ? KINDS.find(([type]) => MediaRecorder.isTypeSupported(type)) : undefined;
  let recorder: MediaRecorder | undefined;
  const label = (on: boolean): void => {
    element.textContent = on ? 'End the video' : title;
    element.setAttribute('aria-pressed', String(on));
  };
  const element = button('', () => {
    if (recorder !== undefined) {
      recorder.stop();
      return;
    }
    const picture = kind === undefined ? null : begin();
    if (picture === null || kind === undefined) return;
    const [type, ending] = kind;
    const parts: Blob[] = [];
    const made = new MediaRecorder(picture.captureStream(RATE), { mimeType: type });
    made.addEventListener('dataavailable', ({ data }) => { parts.push(data); });
    made.addEventListener('stop', () => {
      recorder = undefined;
      end?.();
      label(false);
      download(`${name()}.${ending}`, new Blob(parts, { type }));
    });
    made.start();
    recorder = made;
    label(true);
  }, style);
  element.hidden = kind === undefined;
  label(false);
  return element;
}
