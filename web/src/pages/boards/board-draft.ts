/** A board while it is arranged: every step can be taken back. Pure but for its own state. */

import { COLUMNS, firstFree, itemsOf, type GridItem, type GridName } from "../../boards/grid.js";
import type { BoardShape, BoardTileShape } from "../../generated/api.js";
import { EditHistory } from "../../state/edit-history.js";
import { boardTileEntry } from "../../tiles/board/board-catalog.js";
import { tileSize } from "./board-view.js";

export class BoardDraft {
  private readonly history: EditHistory;
  private readonly original: string;

  constructor(board: BoardShape) {
    this.original = JSON.stringify(board);
    this.history = new EditHistory(this.original);
  }

  get board(): BoardShape {
    return JSON.parse(this.history.text) as BoardShape;
  }

  get isChanged(): boolean {
    return this.history.text !== this.original;
  }

  get canUndo(): boolean {
    return this.history.canUndo;
  }

  get canRedo(): boolean {
    return this.history.canRedo;
  }

  undo(): void {
    this.history.undoEdit();
  }

  redo(): void {
    this.history.redoEdit();
  }

  /** @param along it goes on with the last change, as typing does */
  change(change: Partial<BoardShape>, along = false): void {
    this.history.recordEdit(JSON.stringify({ ...this.board, ...change }), along);
  }

  changeTile(tile: BoardTileShape): void {
    this.change({ tiles: this.board.tiles.map((other) => (other.id === tile.id ? tile : other)) }, true);
  }

  /** Tiles as they now stand on one of the grids. */
  arrange(items: readonly GridItem[], grid: GridName): void {
    const places = new Map(items.map(({ id, x, y, w, h }) => [id, { x, y, w, h }]));
    this.change({ tiles: this.board.tiles.map((tile) => ({ ...tile, [grid]: places.get(tile.id) ?? tile[grid] })) });
  }

  /** Adds a tile where there is room; gives its id. */
  addTile(type: string): string {
    const { tiles } = this.board;
    const id = freeId(tiles);
    const standard = (boardTileEntry(type)?.settings ?? []).flatMap(({ key, standard: value }) => (value === undefined ? [] : [[key, value] as const]));
    const bare: BoardTileShape = { id, type, title: "", settings: Object.fromEntries(standard), desktop: null, phone: null };
    const [w, h] = tileSize(bare, "desktop");
    const desktop = firstFree(itemsOf(tiles, "desktop", tileSize), w, h, COLUMNS.desktop);
    this.change({ tiles: [...tiles, { ...bare, desktop }] });
    return id;
  }

  removeTile(id: string): void {
    this.change({ tiles: this.board.tiles.filter((tile) => tile.id !== id) });
  }
}

function freeId(tiles: readonly BoardTileShape[]): string {
  const taken = new Set(tiles.map(({ id }) => id));
  for (let number = tiles.length + 1; ; number += 1) {
    if (!taken.has(`t${String(number)}`)) return `t${String(number)}`;
  }
}
