// The closed-form models, with the library's names.
import { engine } from './engine.ts';
import { System } from './system.ts';

/** A planar arm of two uniform rods; without gravity it moves in a horizontal plane. */
export class Reach2R extends System {
  static uniform(l1: number, m1: number, l2: number, m2: number, gravity: number): Reach2R {
    return new Reach2R(engine.ClosedForm.reach2R(l1, m1, l2, m2, gravity), 2);
  }

  /** Rods of 1 m, 2 kg and 1 m, 1 kg in Earth's gravity. */
  static workedExample(): Reach2R {
    return Reach2R.uniform(1, 2, 1, 1, 9.81);
  }
}

/** A planar arm of three rods. */
export class PlanarArm extends System {
  static reach3R(): PlanarArm {
    return new PlanarArm(engine.ClosedForm.reach3R(), 3);
  }
}

/** A revolute and a prismatic link. */
export class RpArm extends System {
  static of(r1: number, m1: number, i1: number, m2: number, i2: number, gravity: number): RpArm {
    return new RpArm(engine.ClosedForm.rpArm(r1, m1, i1, m2, i2, gravity), 2);
  }
}

/** A point mass in polar coordinates. */
export class PolarMass extends System {
  static of(mass: number, gravity = 0): PolarMass {
    return new PolarMass(engine.ClosedForm.polarMass(mass, gravity), 2);
  }
}

/** A free body in the plane. */
export class PlanarBody extends System {
  static of(mass: number, inertia: number, gravity = 0): PlanarBody {
    return new PlanarBody(engine.ClosedForm.planarBody(mass, inertia, gravity), 3);
  }
}
