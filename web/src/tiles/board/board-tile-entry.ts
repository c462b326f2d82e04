/** What a tile of boards is: one entry of the catalogue, and what it is handed. */

import type { TemplateResult } from "lit";
import type { BoardSubjects } from "../../boards/references.js";
import type { SettingField, TileSettings } from "../../boards/tile-settings.js";
import type { CommandClient } from "../../controllers/drive/command-client.js";
import type { IconName } from "../../elements/base/icons.js";
import type { ChartSamples } from "../../elements/chart/chart-model.js";
import type { PaintScheduler } from "../../elements/chart/paint-scheduler.js";
import type { GapShape, SignalShape, TileShape } from "../../generated/api.js";
import type { TimeSpan } from "../../series/time-window.js";
import type { PastBoard } from "../../state/past/past-board.js";
import type { PictureTimes } from "./picture-times.js";

/** Samples of a board's charts: what comes, or what came up to a past moment. */
export interface TileSamples {
  channelOf(address: string): { readonly trace: ChartSamples; readonly gaps: readonly GapShape[] };
  /** Age of the newest sample (s); NaN before the first. */
  ageS(address: string): number;
  /** The window that ends now, or at the moment. */
  currentWindow(nowMs: number): TimeSpan;
}

/** What every tile of a board is handed; the same object while nothing of it has changed. */
export interface BoardTileContext extends BoardSubjects {
  readonly site: string;
  readonly zone: string;
  /** Site and page are linked: what comes now is of now. Always so of a past moment, of which the values' ages tell. */
  readonly online: boolean;
  /** Site and page are linked now, whatever moment is shown. */
  readonly linked: boolean;
  /** The past moment that the board shows; null for now. */
  readonly past: PastBoard | null;
  /** Samples of the signals that `feeds` names; null outside a page. */
  readonly feed: TileSamples | null;
  readonly painter: PaintScheduler;
  /** Sends commands; null for who may use nothing of the site. */
  readonly line: CommandClient | null;
  readonly pictures: PictureTimes;
  /** Tiles of the hub's administrator. */
  readonly extensions: readonly TileShape[];
}

/** What charts need of the past and of every sample. */
export interface TileFeed {
  readonly signals: readonly SignalShape[];
  readonly seconds: number;
}

/** Lists of a past moment are asked for again when it has moved by this much (µs). */
const TURN_US = 5e6;

/** The moment for who asks the hub for a list: it stands still for a while, playing, and is exact when it stands. */
export function pastTurn({ playing, us }: PastBoard): number {
  return Math.floor(playing ? Math.floor(us / TURN_US) * TURN_US : us);
}

export type TileSize = readonly [w: number, h: number];

export interface BoardTileEntry {
  /** As boards name it. */
  readonly type: string;
  readonly title: string;
  /** What it shows, for who chooses. */
  readonly about: string;
  readonly icon: IconName;
  /** Columns and rows on the two grids, and the least. */
  readonly desktop: TileSize;
  readonly phone: TileSize;
  readonly least: TileSize;
  readonly settings: readonly SettingField[];
  /** Makes its element known. */
  readonly load: () => Promise<unknown>;
  readonly render: (settings: TileSettings, context: BoardTileContext) => TemplateResult;
  /** The title where the person gave none; without it the entry's own. */
  readonly titleOf?: (settings: TileSettings, context: BoardTileContext) => string;
  /** It hears keys: while the board is arranged by keys, it is not there. */
  readonly rests?: boolean;
  /**
   * How it shows a past moment: `moves` as it shows now, from the history; or what stands in its place. Without it,
   * nothing that it shows is recorded.
   */
  readonly past?: "moves" | ((settings: TileSettings, context: BoardTileContext) => TemplateResult);
  /** Said where nothing that it shows is recorded: why. */
  readonly notKept?: string;
  readonly feeds?: (settings: TileSettings, context: BoardSubjects) => TileFeed;
}
