/** What a tile of boards is: one entry of the catalogue, and what it is handed. */

import type { TemplateResult } from "lit";
import type { BoardSubjects } from "../../boards/references.js";
import type { SettingField, TileSettings } from "../../boards/tile-settings.js";
import type { CommandClient } from "../../controllers/drive/command-client.js";
import type { IconName } from "../../elements/base/icons.js";
import type { PaintScheduler } from "../../elements/chart/paint-scheduler.js";
import type { SignalShape, TileShape } from "../../generated/api.js";
import type { ChartFeed } from "../chart/chart-feed.js";
import type { PictureTimes } from "./picture-times.js";

/** What every tile of a board is handed; the same object while nothing of it has changed. */
export interface BoardTileContext extends BoardSubjects {
  readonly site: string;
  readonly zone: string;
  /** Site and page are linked: what comes now is of now. */
  readonly online: boolean;
  /** Samples of the signals that `feeds` names; null outside a page. */
  readonly feed: ChartFeed | null;
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
  readonly feeds?: (settings: TileSettings, context: BoardSubjects) => TileFeed;
}
