/** Rotations and shifts in space, as REP-103 has them: x forward, y left, z up; m and rad. Pure. */

export type Vector = readonly [x: number, y: number, z: number];
/** Of unit length. */
export type Quaternion = readonly [x: number, y: number, z: number, w: number];

/** A pose, or how one frame stands in another. */
export interface Transform {
  readonly at: Vector;
  readonly turn: Quaternion;
}

export const IDENTITY: Transform = { at: [0, 0, 0], turn: [0, 0, 0, 1] };

/** Of unit length; one without length (a message nobody filled) turns nothing. */
export function normalized([x, y, z, w]: Quaternion): Quaternion {
  const size = Math.hypot(x, y, z, w);
  return size > 1e-9 && Number.isFinite(size) ? [x / size, y / size, z / size, w / size] : [0, 0, 0, 1];
}

/** First `b`, then `a`. */
export function multiplied(a: Quaternion, b: Quaternion): Quaternion {
  const [ax, ay, az, aw] = a;
  const [bx, by, bz, bw] = b;
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

export function turned(turn: Quaternion, [x, y, z]: Vector): Vector {
  const [qx, qy, qz, qw] = turn;
  // v + 2 q × (q × v + w v)
  const cx = qy * z - qz * y + qw * x;
  const cy = qz * x - qx * z + qw * y;
  const cz = qx * y - qy * x + qw * z;
  return [x + 2 * (qy * cz - qz * cy), y + 2 * (qz * cx - qx * cz), z + 2 * (qx * cy - qy * cx)];
}

/** A point of the inner frame in the outer one. */
export function applied({ at, turn }: Transform, point: Vector): Vector {
  const [x, y, z] = turned(turn, point);
  return [x + at[0], y + at[1], z + at[2]];
}

/** `b` stands in `a`'s frame: how it stands in the frame around. */
export function composed(a: Transform, b: Transform): Transform {
  return { at: applied(a, b.at), turn: multiplied(a.turn, b.turn) };
}

export function inverted({ at, turn }: Transform): Transform {
  const back: Quaternion = [-turn[0], -turn[1], -turn[2], turn[3]];
  const [x, y, z] = turned(back, at);
  return { at: [-x, -y, -z], turn: back };
}

/** Between two, on the shorter way: 0 is the first, 1 the second. */
export function between(a: Transform, b: Transform, share: number): Transform {
  const mix = (i: 0 | 1 | 2): number => a.at[i] + share * (b.at[i] - a.at[i]);
  return { at: [mix(0), mix(1), mix(2)], turn: slerped(a.turn, b.turn, share) };
}

function slerped(a: Quaternion, b: Quaternion, share: number): Quaternion {
  let cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const sign = cosine < 0 ? -1 : 1;
  cosine *= sign;
  let first = 1 - share;
  let second = share;
  // Nearly the same: the arc is a line, and its sine would be divided by.
  if (cosine < 0.9995) {
    const angle = Math.acos(Math.min(1, cosine));
    first = Math.sin(first * angle) / Math.sin(angle);
    second = Math.sin(second * angle) / Math.sin(angle);
  }
  second *= sign;
  return normalized([
    first * a[0] + second * b[0],
    first * a[1] + second * b[1],
    first * a[2] + second * b[2],
    first * a[3] + second * b[3],
  ]);
}

/** Heading (rad, counter-clockwise from x). */
export function yawOf([x, y, z, w]: Quaternion): number {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

export function turnOfYaw(yaw: number): Quaternion {
  return [0, 0, Math.sin(yaw / 2), Math.cos(yaw / 2)];
}
