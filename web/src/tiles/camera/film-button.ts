/** Begins and ends the film of a camera; not there for who may not. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { css, html, LitElement, nothing } from "lit";
import { customElement, property } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { FilmRecordingController } from "../../controllers/film-recording.js";
import { base } from "../../elements/base/base-style.js";
import { onPicture } from "../../elements/camera/picture-overlay.js";
import { apiContext } from "../../state/contexts.js";
import { FilmsApi } from "../../wire/films-api.js";
import type { HubApi } from "../../wire/hub-api.js";

const DOT = "M12 6a6 6 0 1 0 0 12A6 6 0 0 0 12 6Z";
const BLOCK = "M7 7h10v10H7z";

@customElement("t-film-button")
export class FilmButton extends LitElement {
  static override styles = [
    base,
    onPicture,
    css`
      :host {
        position: relative;
        display: inline-block;
      }
      svg {
        color: var(--t-bad);
      }
      .key[aria-pressed="true"] {
        border: 2px solid var(--t-bad);
      }
      @container (inline-size < 32rem) {
        .word {
          display: none;
        }
      }
      .problem {
        position: absolute;
        inset-block-end: calc(100% + var(--t-space-1));
        inset-inline-end: 0;
        inline-size: max-content;
        max-inline-size: 16rem;
        padding: var(--t-space-2);
        border: 2px solid var(--t-bad);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font-size: var(--t-size-s);
      }
    `,
  ];

  @property() site = "";
  @property() stream = "";

  @consume({ context: apiContext, subscribe: true }) private api: HubApi | undefined;

  private readonly filming = new FilmRecordingController(this);
  private readonly action = new ActionController(this);
  /** What was asked for, until the gateway says that it is so. */
  private asked: boolean | null = null;

  protected override willUpdate(): void {
    this.filming.setSite(this.api, this.site);
    if (this.asked !== null && this.filming.list?.filming.includes(this.stream) === this.asked) this.asked = null;
  }

  override render(): unknown {
    const { list } = this.filming;
    if (list?.may_film !== true || this.stream === "") return nothing;
    const on = list.filming.includes(this.stream);
    const label = on ? msg("End the film") : msg("Film this camera");
    const { problem } = this.action;
    return html`<button type="button" class="key ${on ? "worded" : ""}" aria-label=${label} title=${label} aria-pressed=${on ? "true" : "false"} aria-busy=${this.asked === null ? "false" : "true"} @click=${this.toggleRecording}>
        <svg viewBox="0 0 24 24" aria-hidden="true"><path d=${on ? BLOCK : DOT} fill="currentColor"></path></svg>
        ${on ? html`<span class="word">${msg("Filming")}</span>` : nothing}
      </button>
      ${problem === null ? nothing : html`<span class="problem" role="alert">${problem.what} ${problem.how}</span>`}`;
  }

  private readonly toggleRecording = (): void => {
    const { api, site, stream } = this;
    if (api === undefined) return;
    const on = this.filming.list?.filming.includes(stream) !== true;
    void this.action.run(on ? msg("begin the film") : msg("end the film"), () => new FilmsApi(api).setRecording(site, stream, on)).then((done) => {
      this.asked = done ? on : null;
      // The gateway tells it a moment later.
      setTimeout(() => {
        this.filming.refresh();
      }, 300);
    });
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-film-button": FilmButton;
  }
}
