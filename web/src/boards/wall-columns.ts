/** How many columns a wall of cameras has, so that their pictures are as large as they can be. Pure. */

/** Width over height of a picture, as most cameras have it. */
const PICTURE = 4 / 3;

/** @param room what the wall has (CSS px); zeros while it was not measured */
export function wallColumns(count: number, room: { readonly width: number; readonly height: number }): number {
  if (count < 2 || room.width === 0 || room.height === 0) return 1;
  let best = { columns: 1, width: 0 };
  for (let columns = 1; columns <= count; columns++) {
    const rows = Math.ceil(count / columns);
    const width = Math.min(room.width / columns, (room.height / rows) * PICTURE);
    if (width > best.width) best = { columns, width };
  }
  return best.columns;
}
