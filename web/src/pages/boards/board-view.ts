/** A board with its tiles at work: it subscribes to what they show, and lets them be arranged. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { keyed } from "lit/directives/keyed.js";
import { repeat } from "lit/directives/repeat.js";
import { COLUMNS, itemsOf, type GridName } from "../../boards/grid.js";
import { CommandClient } from "../../controllers/drive/command-client.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ElementSizeController } from "../../controllers/element-size.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import type { NamedItem } from "../../elements/board/board-grid.js";
import { PaintScheduler } from "../../elements/chart/paint-scheduler.js";
import type { BoardShape, BoardTileShape, DeviceShape, SignalShape, SiteShape, TileShape } from "../../generated/api.js";
import { SECOND_US } from "../../series/zone-clock.js";
import type { PastBoard } from "../../state/past/past-board.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { boardTileEntry } from "../../tiles/board/board-catalog.js";
import type { BoardTileContext } from "../../tiles/board/board-tile-entry.js";
import { PictureTimes } from "../../tiles/board/picture-times.js";
import { ChartFeed } from "../../tiles/chart/chart-feed.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/board/board-grid.js";
import "../../elements/feedback/empty.js";
import "../../tiles/board/board-tile.js";
import "../../tiles/board/past-scope.js";

const UNKNOWN_SIZE: readonly [number, number] = [3, 3];

/** The size that a tile gets where it has no place. */
export function tileSize({ type }: BoardTileShape, grid: GridName): readonly [w: number, h: number] {
  return boardTileEntry(type)?.[grid] ?? UNKNOWN_SIZE;
}

/** The events of `t-board-grid` come through. */
@customElement("t-board-view")
export class BoardView extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        min-inline-size: 0;
      }
    `,
  ];

  @property({ attribute: false }) board: BoardShape | null = null;
  @property({ attribute: false }) detail: SiteShape | null = null;
  @property({ attribute: false }) device: DeviceShape | null = null;
  @property({ attribute: false }) extensions: readonly TileShape[] = [];
  @property() grid: GridName = "desktop";
  @property({ type: Boolean }) editing = false;
  /** The past moment that is shown; null for now. */
  @property({ attribute: false }) past: PastBoard | null = null;

  @consume({ context: apiContext }) private readonly api: HubApi | undefined;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly link = new ConnectionStateController(this);
  private readonly size = new ElementSizeController(this);
  private readonly painter = new PaintScheduler();
  private readonly pictures = new PictureTimes();
  private feed: ChartFeed | null = null;
  private line: CommandClient | null = null;
  private built = "";
  private context: BoardTileContext | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.closeClients();
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    const { board, detail, api } = this;
    const { connection } = this.link;
    const wanted = detail !== null && connection !== undefined && api !== undefined && this.isConnected ? detail.site : "";
    if (wanted !== this.built) this.closeClients();
    this.built = wanted;
    if (wanted !== "" && connection !== undefined && api !== undefined) {
      this.feed ??= new ChartFeed(wanted, connection, api, this.onSamples, 300 * SECOND_US);
      if (this.line === null && detail?.devices.some(({ rights }) => rights.includes("use")) === true) {
        this.line = new CommandClient(connection, wanted);
        this.line.open();
      }
    }
    if (detail !== null) this.makeContext(detail, changed);
    if (board !== null) this.subscribeTiles(board);
  }

  override render(): TemplateResult | typeof nothing {
    const { board, context, grid, past } = this;
    if (board === null || context === null) return nothing;
    if (board.tiles.length === 0) {
      return html`<t-empty heading=${msg("No tile yet")} icon="devices"><p>${this.editing ? msg("Add the first one: it goes where there is room.") : msg("Nothing stands on this board yet.")}</p></t-empty>`;
    }
    const tiles = new Map(board.tiles.map((tile) => [tile.id, tile]));
    // In the order in which they are read, so that Tab goes through them like the eye.
    const items = [...itemsOf(board.tiles, grid, tileSize)].sort((a, b) => a.y - b.y || a.x - b.x);
    const named = items.map((item): NamedItem => {
      const tile = tiles.get(item.id);
      const entry = boardTileEntry(tile?.type ?? "");
      const name = tile?.title || (entry?.titleOf?.(tile?.settings ?? {}, context) ?? entry?.title ?? msg("Tile"));
      return { ...item, name, least: entry?.least ?? [1, 1] };
    });
    const tileGrid = html`<t-board-grid .items=${named} .grid=${grid} ?editing=${this.editing} @t-arrange=${this.passOn} @t-settings=${this.passOn} @t-remove=${this.passOn}>
      ${repeat(
        items,
        ({ id }) => id,
        ({ id }) => html`<t-board-tile slot=${id} .tile=${tiles.get(id) ?? null} .context=${context} ?past=${past !== null} ?arranged=${this.editing} ?inert=${this.editing}></t-board-tile>`,
      )}
    </t-board-grid>`;
    // Made anew for another past: nothing that a tile holds of now is seen in it, nor the other way round.
    return html`${keyed(past, past === null ? tileGrid : html`<t-past-scope .past=${past}>${tileGrid}</t-past-scope>`)}`;
  }

  /** The same object while nothing of it has changed: every tile would be drawn again. */
  private makeContext(detail: SiteShape, changed: PropertyValues<this>): void {
    const { past } = this;
    const linked = (this.sites.store?.siteRow(detail.site)?.online ?? detail.online) && this.link.state === "open";
    const before = this.context;
    const same = before !== null && before.linked === linked && before.feed === (past?.feed ?? this.feed) && before.line === (past === null ? this.line : null) && before.past === past;
    if (same && !changed.has("detail") && !changed.has("device") && !changed.has("extensions")) return;
    this.context = {
      site: detail.site, zone: detail.zone, detail, device: this.device, online: linked || past !== null, linked, past, feed: past?.feed ?? this.feed,
      painter: this.painter, pictures: this.pictures, line: past === null ? this.line : null, extensions: this.extensions,
    };
  }

  /** Pixels across the widest tile that draws samples; of pairs all are drawn, however wide it is. */
  private widestChart(tiles: readonly BoardTileShape[], context: BoardTileContext): number {
    const drawn = new Map(tiles.flatMap(({ id, type, settings }) => ((boardTileEntry(type)?.feeds?.(settings, context).signals.length ?? 0) > 0 ? [[id, type] as const] : [])));
    if ([...drawn.values()].includes("xy")) return Infinity;
    const columns = Math.max(0, ...itemsOf(tiles, this.grid, tileSize).map(({ id, w }) => (drawn.has(id) ? w : 0)));
    const width = this.size.size.width || this.clientWidth;
    // Not laid out yet: it may become wide.
    return width === 0 ? Infinity : (width * columns) / COLUMNS[this.grid];
  }

  private subscribeTiles({ tiles }: BoardShape): void {
    const { context, feed } = this;
    if (context === null || feed === null) return;
    const feeds = tiles.flatMap(({ type, settings }) => boardTileEntry(type)?.feeds?.(settings, context) ?? []);
    const signals = [...new Set(feeds.flatMap((wanted): readonly SignalShape[] => wanted.signals))];
    const lengthUs = Math.max(60, ...feeds.map(({ seconds }) => seconds)) * SECOND_US;
    this.past?.feed.setWidth(this.widestChart(tiles, context));
    this.past?.feed.setLength(lengthUs);
    this.past?.feed.subscribeSignals(signals);
    feed.setLength(lengthUs);
    // What comes now is seen by nobody while the board looks back.
    feed.subscribeSignals(this.past === null ? signals : []);
  }

  private closeClients(): void {
    this.feed?.close();
    this.line?.close();
    this.feed = null;
    this.line = null;
    this.built = "";
  }

  private readonly onSamples = (): void => {
    this.painter.wakeUp();
  };

  private readonly passOn = (event: CustomEvent<unknown>): void => {
    this.dispatchEvent(new CustomEvent(event.type, { detail: event.detail }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-board-view": BoardView;
  }
}
