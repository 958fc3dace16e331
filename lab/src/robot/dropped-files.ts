// Files that the user drops or chooses, by path.
import { html } from '../element.ts';

/** All files of a drop, with the contents of folders. */
export async function droppedFiles(transfer: DataTransfer): Promise<Map<string, Blob>> {
  const files = new Map<string, Blob>();
  const entries = Array.from(transfer.items, (item) => item.webkitGetAsEntry());
  const loose = Array.from(transfer.files);
  if (entries.every((entry) => entry === null)) {
    for (const file of loose) files.set(file.name, file);
    return files;
  }
  const walk = async (entry: FileSystemEntry): Promise<void> => {
    if (entry.isFile) {
      const file = await new Promise<File>((resolve, reject) => { (entry as FileSystemFileEntry).file(resolve, reject); });
      files.set(entry.fullPath.replace(/^\//, ''), file);
      return;
    }
    const reader = (entry as FileSystemDirectoryEntry).createReader();
    // A folder is read in parts; an empty one is the end.
    for (;;) {
      const piece = await new Promise<FileSystemEntry[]>((resolve, reject) => { reader.readEntries(resolve, reject); });
      if (piece.length === 0) return;
      for (const one of piece) await walk(one);
    }
  };
  for (const entry of entries) if (entry !== null) await walk(entry);
  return files;
}

/** Asks for files or a folder, and passes them on. */
export function fileInput(label: string, folder: boolean, open: (files: Map<string, Blob>) => Promise<void>): HTMLInputElement {
  const input = html('input', {
    type: 'file', class: 'visually-hidden', tabindex: -1, 'aria-label': label, webkitdirectory: folder || undefined,
    accept: folder ? undefined : '.urdf,.xml,.mjcf,.sdf,.scene,.zip', multiple: !folder || undefined,
    change: () => {
      void open(new Map(Array.from(input.files ?? [], (file) => [file.webkitRelativePath || file.name, file])));
      input.value = '';
    },
  });
  return input;
}
