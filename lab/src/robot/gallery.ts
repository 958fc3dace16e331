// The robots that the page offers.

const FILES = import.meta.glob<string>(['../../../robots/*.urdf', '../../../robots/*.xml'], { query: '?raw', import: 'default' });

const TITLES: Record<string, string> = {
  panda: 'Panda', ur5: 'UR5', two_r: 'Two rods', three_r: 'Three rods', dual_arm: 'Two arms', gantry: 'Gantry', gripper: 'Gripper',
  hand: 'Hand', humanoid: 'Humanoid', quadruped: 'Quadruped', 'arm.xml': 'Arm, MJCF', 'hand.xml': 'Hand, MJCF',
  'linkage.xml': 'Linkage, MJCF', 'quadruped.xml': 'Quadruped, MJCF',
  'gripper_and_box.xml': 'Gripper and box, MJCF',
};

/** A URDF file does not tell that a robot walks. */
const LEGGED = new Set(['humanoid', 'quadruped']);

export interface Bundled {
  /** As in the address: a URDF file without its extension. */
  name: string;
  title: string;
  /** Whether it floats on the page although its file fixes the base. */
  floats: boolean;
  read: () => Promise<string>;
}

export const GALLERY: readonly Bundled[] = Object.entries(FILES)
  .map(([path, read]) => {
    const name = path.replace(/^.*\/|\.urdf$/g, '');
    return { name, title: TITLES[name] ?? name.replace(/_/g, ' '), floats: LEGGED.has(name), read };
  })
  .sort((a, b) => rank(a.name) - rank(b.name));

function rank(name: string): number {
  const at = Object.keys(TITLES).indexOf(name);
  return at < 0 ? Infinity : at;
}
