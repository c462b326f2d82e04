/** A card around a web component of the hub's administrator; what it throws stays in the card. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { LiveValuesController } from "../controllers/live-values.js";
import { outOfRange, stateWord } from "../format/state-label.js";
import { base, panelBox } from "../elements/base/base-style.js";
import type { DeviceShape, SignalShape, TileShape } from "../generated/api.js";
import { signalsFor } from "./catalog.js";
import { TILE_API_VERSION, type TileFreshness, type TileReading, type TileView } from "./extension-view.js";

type TileElement = HTMLElement & { update(view: TileView): void };
type TileConstructor = new () => TileElement;

/** One module for each tile, however many devices show it. */
const classes = new Map<string, Promise<TileConstructor>>();

@customElement("t-extension-tile")
export class ExtensionTile extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        align-content: start;
        gap: var(--t-space-2);
        padding: var(--t-space-4);
        ${panelBox}
        min-inline-size: 0;
        overflow: hidden;
      }
      :host([bare]) {
        padding: 0;
        border: 0;
        background: none;
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) device: DeviceShape | null = null;
  @property({ attribute: false }) tile: TileShape | null = null;
  @property({ type: Boolean }) online = false;
  /** What is around it has a head and a box already. */
  @property({ type: Boolean, reflect: true }) bare = false;
  /** Why the component cannot be shown; empty while it can. */
  @state() private problem = "";

  @query(".component") private readonly place!: HTMLElement | null;

  private readonly live = new LiveValuesController(this);
  private component: TileElement | null = null;
  private begun = false;

  override willUpdate(): void {
    this.live.observeChannels(this.site, [...this.signals().values()].flatMap(({ channels }) => channels.slice(0, 1)));
  }

  override render(): TemplateResult {
    if (this.problem !== "") {
      return html`${this.renderHead()}
        <p role="alert">${msg(html`The tile “${this.tile?.name}” in the hub's extensions folder cannot be shown:`)} ${this.problem}</p>`;
    }
    return html`${this.renderHead()}
      <div class="component"></div>`;
  }

  private renderHead(): TemplateResult | typeof nothing {
    return this.bare ? nothing : html`<h3>${this.tile?.title}</h3>`;
  }

  protected override updated(changed: PropertyValues<this>): void {
    if (this.tile === null || this.problem !== "") return;
    if (!this.begun) {
      this.begun = true;
      void this.begin(this.tile);
    }
    if (!changed.has("tile")) this.updateComponent();
  }

  private async begin(tile: TileShape): Promise<void> {
    try {
      const Component = await loadTile(tile);
      const component = new Component();
      const { place } = this;
      if (place === null) return;
      const thrown = errorsDuring(() => {
        place.append(component);
      });
      if (thrown !== null) throw thrown;
      this.component = component;
      this.updateComponent();
    } catch (error) {
      this.fail(error);
    }
  }

  private updateComponent(): void {
    try {
      this.component?.update(this.view());
    } catch (error) {
      this.fail(error);
    }
  }

  private fail(error: unknown): void {
    this.component?.remove();
    this.component = null;
    this.problem = String(error);
  }

  private signals(): ReadonlyMap<string, SignalShape> {
    if (this.tile === null || this.device === null) return new Map();
    return signalsFor(this.tile, this.device) ?? new Map<string, SignalShape>();
  }

  private view(): TileView {
    const { id = "", name = "", kind = "other" } = this.device ?? {};
    const readings = Object.fromEntries([...this.signals()].map(([own, signal]) => [own, this.readingOf(signal)]));
    return { api: TILE_API_VERSION, site: this.site, device: { id, name, kind }, readings };
  }

  private readingOf(signal: SignalShape): TileReading {
    const { id, name, unit, type } = signal;
    const channel = signal.channels[0] ?? signal.address;
    const reading = this.live.readingOf(channel);
    const value = reading?.value ?? Number.NaN;
    const text = reading === undefined ? "" : type === "state" ? stateWord(signal.states, value) : (reading.text ?? "");
    return { id, name, unit, value, text, freshness: this.freshnessOf(signal, channel, value), ageS: this.live.ageS(channel) };
  }

  private freshnessOf(signal: SignalShape, channel: string, value: number): TileFreshness {
    const now = this.live.freshnessOf(channel, signal.max_age);
    if (now === "live" && outOfRange(signal, value)) return "outside";
    if (now === "live") return this.online ? "live" : "unknown";
    return now === "stale" ? "stale" : "unknown";
  }
}

/** Imports a tile's module and registers its default export as an element of a name of its own. */
function loadTile(tile: TileShape): Promise<TileConstructor> {
  const known = classes.get(tile.module);
  if (known !== undefined) return known;
  const loading = import(/* @vite-ignore */ tile.module).then((module: { readonly default?: unknown }) => {
    const found = module.default;
    if (typeof found !== "function" || !(found.prototype instanceof HTMLElement) || !("update" in found.prototype)) {
      throw new TypeError("its default export is no HTMLElement with a method update(view)");
    }
    customElements.define(`talaia-tile-${tile.name}`, found as TileConstructor);
    return found as TileConstructor;
  });
  classes.set(tile.module, loading);
  return loading;
}

/** What a custom element throws while it is connected goes to the window, not to who connects it. */
function errorsDuring(act: () => void): Error | null {
  const thrown: Error[] = [];
  const listen = (event: ErrorEvent): void => {
    event.preventDefault();
    thrown.push(event.error instanceof Error ? event.error : new Error(event.message));
  };
  window.addEventListener("error", listen);
  try {
    act();
  } finally {
    window.removeEventListener("error", listen);
  }
  return thrown[0] ?? null;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-extension-tile": ExtensionTile;
  }
}
