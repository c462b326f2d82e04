/** The films beside the charts: each camera's, and what plays them. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, queryAll, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { base, panelBox, quietText } from "../../../elements/base/base-style.js";
import { momentText } from "../../../elements/chart/cursor-values.js";
import { plural } from "../../../words/plural.js";
import { formatClock, knownZone } from "../../../format/time.js";
import type { FilmController } from "./film-controller.js";
import type { FilmView } from "../../../tiles/camera/film-view.js";
import { SPEEDS } from "../../../state/past/playhead.js";
import "../../../tiles/camera/film-view.js";

/** So many cameras are shown before a person has chosen. */
const FIRST_CAMERAS = 4;

const PLAY = "M7 4.5v15l12-7.5z";
const PAUSE = "M7 4.5h3.5v15H7zM13.5 4.5H17v15h-3.5z";
const ON = "M5 5v14l9-7zM16 5h3v14h-3z";
const BACK = "M19 5v14l-9-7zM5 5h3v14H5z";

/**
 * @fires t-moment detail is a moment (µs) to go to
 * @fires t-cameras detail is the addresses of the cameras that are to be shown
 */
@customElement("t-film-panel")
export class FilmPanel extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-2);
        align-content: start;
        padding: var(--t-space-3);
        ${panelBox}
        min-inline-size: 0;
        container-type: inline-size;
      }
      :host(:fullscreen) {
        grid-template-rows: minmax(0, 1fr) auto;
        border: 0;
        border-radius: 0;
        background: var(--t-bg);
      }
      h2 {
        font-size: var(--t-size-m);
      }
      :host(:fullscreen) .head {
        display: none;
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: 0 var(--t-space-3);
      }
      .head label {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-1);
        min-block-size: var(--t-touch);
        font-size: var(--t-size-s);
      }
      .views {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(15rem, 100%), 1fr));
        gap: var(--t-space-2);
        min-block-size: 0;
      }
      @media (max-width: 60rem) {
        .views {
          grid-template-columns: repeat(auto-fit, minmax(9rem, 1fr));
        }
      }
      :host(:fullscreen) .views {
        grid-auto-rows: minmax(0, 1fr);
      }
      :host(:fullscreen) t-film-view {
        aspect-ratio: auto;
      }
      .tools {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-2);
      }
      button {
        display: grid;
        place-content: center;
        inline-size: var(--t-touch);
        block-size: var(--t-touch);
        padding: 0;
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        cursor: pointer;
      }
      button:hover {
        background: var(--t-raised);
      }
      button.main {
        border-color: var(--t-accent);
        background: var(--t-accent);
        color: var(--t-on-accent);
      }
      button svg {
        inline-size: 1.4rem;
        block-size: 1.4rem;
      }
      select {
        min-block-size: var(--t-touch);
        padding-inline: var(--t-space-2);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
      }
      .moment {
        margin-inline-start: auto;
        text-align: end;
        font-variant-numeric: tabular-nums;
        line-height: 1.2;
      }
      .moment strong {
        display: block;
      }
      .moment span {
        ${quietText}
      }
      .hint {
        ${quietText}
      }
      @media (pointer: coarse) {
        .hint {
          display: none;
        }
      }
      :host(:fullscreen) .hint {
        display: none;
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) control: FilmController | null = null;
  /** What of the controller changes; so that the panel is drawn anew. */
  @property({ type: Number }) us = 0;
  @property({ type: Boolean }) playing = false;
  @property({ type: Boolean }) held = false;
  @property({ type: Number }) speed = 1;
  @property({ attribute: false }) reels: FilmController["reels"] = [];
  /** Cameras that a person has chosen; null when nobody has. */
  @property({ attribute: false }) chosen: readonly string[] | null = null;
  @property() zone = "UTC";

  @state() private full = false;
  @queryAll("t-film-view") private readonly views!: NodeListOf<FilmView>;

  override connectedCallback(): void {
    super.connectedCallback();
    document.addEventListener("fullscreenchange", this.onFullScreenChange);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    document.removeEventListener("fullscreenchange", this.onFullScreenChange);
  }

  /** Does what a key asks for; whether it was one of ours. */
  handleKey(key: string): boolean {
    switch (key) {
      case " ":
      case "k":
        this.control?.toggle();
        return true;
      case ".":
      case ",":
        this.step(key === "." ? 1 : -1);
        return true;
      case ">":
      case "<":
        this.control?.changeSpeed(key === ">" ? 1 : -1);
        return true;
      case "f":
        this.toggleFullScreen();
        return true;
      default:
        return false;
    }
  }

  protected override updated(): void {
    this.updateWaiting();
  }

  override render(): TemplateResult {
    const shown = this.shown();
    return html`<div class="head">
        <h2>${plural(this.reels.length, msg("Film"), msg("Films"))}</h2>
        ${this.reels.length > 1 ? this.reels.map(({ stream, name }) => this.renderBox(stream, name, shown.includes(stream))) : nothing}
      </div>
      <div class="views">
        ${repeat(
          this.reels.filter(({ stream }) => shown.includes(stream)),
          ({ stream }) => stream,
          (reel) => html`<t-film-view
            data-stream=${reel.stream}
            site=${this.site}
            .reel=${reel}
            .us=${this.us}
            .playing=${this.playing}
            .held=${this.held}
            .speed=${this.speed}
            zone=${this.zone}
            @t-ready=${this.updateWaiting}
          ></t-film-view>`,
        )}
      </div>
      ${this.renderTools()}
      <p class="hint">${msg("Keys: space plays, comma and point step a picture, < and > change the speed, F fills the screen.")}</p>`;
  }

  private renderTools(): TemplateResult {
    const { playing, speed, us } = this;
    return html`<div class="tools" role="group" aria-label=${msg("Films")}>
      ${this.renderTool(msg("A picture back"), BACK, () => {
        this.step(-1);
      })}
      ${this.renderTool(playing ? msg("Pause") : msg("Play"), playing ? PAUSE : PLAY, () => this.control?.toggle(), "main")}
      ${this.renderTool(msg("A picture on"), ON, () => {
        this.step(1);
      })}
      <select aria-label=${msg("Speed")} @change=${this.onSpeedChange}>
        ${map(SPEEDS, (number) => html`<option value=${number} .selected=${number === speed}>${number === 0.5 ? "½" : number}×</option>`)}
      </select>
      ${this.renderTool(this.full ? msg("Leave full screen") : msg("Full screen"), this.full ? "M9 4v5H4M15 4v5h5M9 20v-5H4M15 20v-5h5" : "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5", this.toggleFullScreen, "line")}
      <span class="moment"><strong>${momentText(us, knownZone(this.zone), 0)}</strong><span>${formatClock(us, "UTC")} UTC</span></span>
    </div>`;
  }

  private renderTool(label: string, path: string, act: () => unknown, kind = ""): TemplateResult {
    return html`<button type="button" class=${kind} aria-label=${label} title=${label} @click=${act}>
      <svg viewBox="0 0 24 24" aria-hidden="true">
        <path
          d=${path}
          fill=${kind === "line" ? "none" : "currentColor"}
          stroke=${kind === "line" ? "currentColor" : "none"}
          stroke-width="2"
          stroke-linecap="round"
        ></path>
      </svg>
    </button>`;
  }

  private renderBox(stream: string, name: string, on: boolean): TemplateResult {
    return html`<label><input type="checkbox" .value=${stream} .checked=${on} @change=${this.onCameraChange} /> ${name}</label>`;
  }

  private shown(): readonly string[] {
    return this.chosen ?? this.reels.slice(0, FIRST_CAMERAS).map(({ stream }) => stream);
  }

  private step(by: 1 | -1): void {
    this.control?.pause();
    const moments = [...this.views].map((view) => view.stepTimeUs(this.control?.us ?? this.us, by)).filter((us) => us !== null);
    // With several cameras: to the nearest picture of any of them.
    if (moments.length > 0) this.seekTo(by > 0 ? Math.min(...moments) : Math.max(...moments));
  }

  private seekTo(us: number): void {
    this.dispatchEvent(new CustomEvent("t-moment", { detail: us, bubbles: true, composed: true }));
  }

  /** No film runs ahead of another that has not got its picture yet. */
  private readonly updateWaiting = (): void => {
    if (this.playing) this.control?.setWaiting([...this.views].some((view) => !view.ready));
  };

  private readonly onSpeedChange = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.control?.setSpeed(Number(event.target.value));
  };

  private readonly onCameraChange = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    const { value, checked } = event.target;
    const before = this.shown();
    const detail = this.reels.map(({ stream }) => stream).filter((stream) => (stream === value ? checked : before.includes(stream)));
    this.dispatchEvent(new CustomEvent("t-cameras", { detail }));
  };

  private readonly toggleFullScreen = (): void => {
    if (this.matches(":fullscreen")) void document.exitFullscreen();
    else void this.requestFullscreen().catch(() => undefined);
  };

  private readonly onFullScreenChange = (): void => {
    this.full = this.matches(":fullscreen");
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-film-panel": FilmPanel;
  }
  interface HTMLElementEventMap {
    "t-cameras": CustomEvent<readonly string[]>;
  }
}
