// A film of a picture, as the browser records it.
import { button } from '../controls/choice.ts';
import { download } from '../drawing/plot-group.ts';

/** What browsers record: the first that this one can. */
const KINDS = [['video/webm', 'webm'], ['video/mp4', 'mp4']] as const;
const RATE = 60;

/** A button that records the canvas until it is pressed again, then hands over the file; hidden where nothing can be recorded. */
export function filmButton(canvas: () => HTMLCanvasElement | null, name: () => string): HTMLButtonElement {
  const kind = 'MediaRecorder' in globalThis ? KINDS.find(([type]) => MediaRecorder.isTypeSupported(type)) : undefined;
  let recorder: MediaRecorder | undefined;
  const label = (on: boolean): void => {
    element.textContent = on ? 'End the video' : 'Record a video';
    element.setAttribute('aria-pressed', String(on));
  };
  const element = button('', () => {
    if (recorder !== undefined) {
      recorder.stop();
      return;
    }
    const picture = canvas();
    if (picture === null || kind === undefined) return;
    const [type, ending] = kind;
    const parts: Blob[] = [];
    const made = new MediaRecorder(picture.captureStream(RATE), { mimeType: type });
    made.addEventListener('dataavailable', ({ data }) => { parts.push(data); });
    made.addEventListener('stop', () => {
      recorder = undefined;
      label(false);
      download(`${name()}.${ending}`, new Blob(parts, { type }));
    });
    made.start();
    recorder = made;
    label(true);
  });
  element.hidden = kind === undefined;
  label(false);
  return element;
}
