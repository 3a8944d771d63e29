// What a picture of a body needs: its points as triangles with normals, and matrices (column-major).

/** Triangles of a body that the service tells as a grid of points, strip after smooth strip. */
export function bodyOf({ rows, columns, unit_mm: unit, points, strips }) {
  const bytes = Uint8Array.from(atob(points), (letter) => letter.charCodeAt(0));
  const whole = new DataView(bytes.buffer);
  const at = (row, column) => {
    const place = 6 * (row * columns + column);
    return [0, 2, 4].map((off) => unit * whole.getInt16(place + off, true));
  };
  const mesh = { places: [], normals: [], corners: [] };
  strips.forEach(({ first, last }, k) => {
    const across = first < last ? Array.from({ length: last - first + 1 }, (_, i) => first + i) : [first, last];
    const other = facing(strips, k);
    const folded = (row, i) => other !== null && same(at(row, first + i), at(row, other - i));
    addGrid(mesh, Array.from({ length: rows }, (_, row) => across.map((column) => at(row, column))), folded);
  });
  return filled(mesh);
}

/** The column of a rib's other wall that faces the first column of this one; null: no wall. */
function facing(strips, k) {
  if (strips[k].kind !== "wall") return null;
  return strips[k + 1].kind === "top" ? strips[k + 2].last : strips[k - 2].last;
}

const same = (a, b) => a.every((value, k) => value === b[k]);

/** A cylinder of radius 1 along x, from 0 to 1, with its ends. */
export function cylinder(sides = 48) {
  const mesh = { places: [], normals: [], corners: [] };
  const ring = (x, r) =>
    Array.from({ length: sides + 1 }, (_, k) => [x, r * Math.cos((2 * Math.PI * k) / sides), r * Math.sin((2 * Math.PI * k) / sides)]);
  for (const [a, b] of [[[0, 1e-6], [0, 1]], [[0, 1], [1, 1]], [[1, 1], [1, 1e-6]]]) addGrid(mesh, [ring(...a), ring(...b)]);
  return filled(mesh);
}

/** A grid of places, rows by columns, smooth all over; cells that are `folded` all round are left out. */
function addGrid({ places, normals, corners }, grid, folded = () => false) {
  const start = places.length / 3;
  const [rows, columns] = [grid.length, grid[0].length];
  for (let i = 0; i < rows; i++) {
    for (let k = 0; k < columns; k++) {
      places.push(...grid[i][k]);
      const down = minus(grid[Math.min(i + 1, rows - 1)][k], grid[Math.max(i - 1, 0)][k]);
      const along = minus(grid[i][Math.min(k + 1, columns - 1)], grid[i][Math.max(k - 1, 0)]);
      normals.push(...unitOf(cross(down, along)));
      const whole = i + 1 < rows && k + 1 < columns;
      if (whole && ![0, 1, 2, 3].every((n) => folded(i + (n & 1), k + (n >> 1)))) {
        const here = start + i * columns + k;
        corners.push(here, here + 1, here + columns, here + 1, here + columns + 1, here + columns);
      }
    }
  }
}

const filled = ({ places, normals, corners }) => ({
  places: new Float32Array(places),
  normals: new Float32Array(normals),
  corners: new Uint32Array(corners),
});

// -- vectors and matrices ---------------------------------------------------------------------

export const minus = (a, b) => a.map((value, k) => value - b[k]);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

export function unitOf(a) {
  const length = Math.hypot(...a);
  return length > 0 ? a.map((value) => value / length) : [0, 0, 0];
}

/** Columns of a placed frame: three vectors and an origin. */
export const framed = (x, y, z, origin) => [...x, 0, ...y, 0, ...z, 0, ...origin, 1];

export function times(a, b) {
  const made = new Array(16).fill(0);
  for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++) for (let k = 0; k < 4; k++) made[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return made;
}

/** A turn about z [rad]. */
export const turn = (angle) =>
  framed([Math.cos(angle), Math.sin(angle), 0], [-Math.sin(angle), Math.cos(angle), 0], [0, 0, 1], [0, 0, 0]);

/** A frame whose x axis leads from one place along a vector, as long as it; across, ``radius``. */
export function along(place, vector, radius) {
  const x = unitOf(vector);
  const helper = Math.abs(x[2]) < 0.9 ? [0, 0, 1] : [0, 1, 0];
  const y = unitOf(cross(helper, x));
  const scaled = (v, factor) => v.map((value) => value * factor);
  return framed(vector, scaled(y, radius), scaled(cross(x, y), radius), place);
}

/** The view from a direction (yaw and pitch [rad]) at a distance. */
export function view(yaw, pitch, distance, centre) {
  const back = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)];
  const right = [-Math.sin(yaw), Math.cos(yaw), 0];
  const up = cross(back, right);
  const eye = centre.map((value, k) => value + distance * back[k]);
  const rows = [right, up, back];
  const turned = [0, 1, 2].flatMap((k) => [...rows.map((row) => row[k]), 0]);
  return [...turned, ...rows.map((row) => -dot(row, eye)), 1];
}

export function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0];
}
