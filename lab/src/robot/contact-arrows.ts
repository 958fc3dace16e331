// Arrows of the contact forces on a robot.
import { type Color, ConeGeometry, CylinderGeometry, Group, Mesh, MeshBasicMaterial, Vector3 } from 'three';

const UP = new Vector3(0, 1, 0);
/** A contact: a point and its force. */
const CONTACT = 6;
/** The length of an arrow for the robot's weight, and the largest length, as fractions of its extent. */
const WEIGHT = 1.6;
const LONGEST = 1.2;

export interface ContactArrows {
  group: Group;
  /** The contacts of a step; `weight` in newtons, `reach` in metres. */
  draw(contacts: Float64Array, weight: number, reach: number): void;
  /** Sets the theme's colour. */
  paint(colour: Color): void;
}

export function contactArrows(colour: Color): ContactArrows {
  const group = new Group();
  // Visible through the robot, which hides its contact points.
  const material = new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.85, depthTest: false });
  group.renderOrder = 1;
  const [shaft, head] = [new CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0), new ConeGeometry(1, 1, 16).translate(0, 0.5, 0)];
  const arrow = (): Group => new Group().add(new Mesh(shaft, material), new Mesh(head, material));
  const along = new Vector3();
  return {
    group,
    draw(contacts, weight, reach) {
      const count = contacts.length / CONTACT;
      while (group.children.length < count) group.add(arrow());
      group.children.forEach((one, i) => {
        one.visible = i < count;
        if (!one.visible) return;
        const [x, y, z, fx, fy, fz] = contacts.subarray(CONTACT * i);
        const force = along.set(fx!, fy!, fz!).length();
        const length = reach * Math.min(LONGEST, WEIGHT * force / weight);
        const width = 0.014 * reach;
        const tip = Math.min(5 * width, 0.6 * length);
        const [body, point] = one.children;
        one.visible = length > width;
        one.position.set(x!, y!, z!);
        one.quaternion.setFromUnitVectors(UP, along.normalize());
        body!.scale.set(width, length - tip, width);
        point!.position.set(0, length - tip, 0);
        point!.scale.set(2.2 * width, tip, 2.2 * width);
      });
    },
    paint(next) {
      material.color.set(next);
    },
  };
}
