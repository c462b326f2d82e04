/** Alarms and the logbook as tiles. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { severityWords } from "../../format/severity.js";
import { eventWords } from "../../format/kinds/event-kinds.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { StoreController } from "../../controllers/store-controller.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, plainList, quietText } from "../../elements/base/base-style.js";
import { alarmStatus } from "../../elements/feedback/alarm-labels.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import type { EventList } from "../../generated/api.js";
import type { AlarmUpdate } from "../../generated/wire.js";
import { alarmsContext, apiContext } from "../../state/contexts.js";
import { alarmPath, sitePath } from "../../state/router.js";
import { AlarmsApi } from "../../wire/alarms-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import { pastTurn, type BoardTileContext } from "./board-tile-entry.js";

const REFRESH_MS = 1500;

const lists = css`
  :host {
    display: grid;
    grid-template-columns: minmax(0, 1fr);
    align-content: start;
  }
  ul {
    ${plainList}
  }
  li {
    display: grid;
    gap: 0 var(--t-space-3);
    padding-block: var(--t-space-1);
    border-block-start: 1px solid var(--t-line);
    overflow-wrap: anywhere;
  }
  li:first-child {
    border-block-start: 0;
  }
  .facts {
    display: flex;
    flex-wrap: wrap;
    gap: 0 var(--t-space-3);
    ${quietText}
  }
  p {
    ${quietText}
  }
`;

@customElement("t-tile-alarms")
export class AlarmsBoardTile extends LitElement {
  static override styles = [base, lists];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  /** Those that are well, too. */
  @property({ type: Boolean }) all = false;

  private readonly alarms = new ContextStoreController(this, alarmsContext);

  constructor() {
    super();
    // A shelf's end comes by itself.
    new TickerController(this, 5000);
  }

  override render(): TemplateResult {
    if ((this.context?.past ?? null) !== null) {
      return html`<p>${msg("What alarms did up to this moment:")}</p><t-tile-logbook .context=${this.context} kind="alarm"></t-tile-logbook>`;
    }
    const { store } = this.alarms;
    const mine = (store?.list ?? []).filter(({ site }) => site === this.context?.site);
    const shown = mine.filter((alarm) => this.all || alarm.phase !== "normal" || !alarm.known);
    if (this.context?.online !== true) {
      return html`<p role="status">${msg("The site is not linked: its alarms are judged again when it is.")}</p>${this.renderList(shown)}`;
    }
    if (shown.length > 0) return this.renderList(shown);
    return mine.length === 0
      ? html`<p>${msg("This site has no alarm that is open to you.")}</p>`
      : html`<p><t-status kind="ok" word=${msg(str`All ${String(mine.length)} are well`)}></t-status></p>`;
  }

  private renderList(shown: readonly AlarmUpdate[]): TemplateResult {
    return html`<ul aria-label=${msg("Alarms")}>
      ${repeat(
        shown,
        ({ alarm }) => alarm,
        (alarm) => {
          const [kind, word] = alarmStatus(alarm, this.alarms.store?.isShelved(alarm) ?? false);
          return html`<li>
            <a href=${alarmPath(alarm)}>${alarm.name}</a>
            <div class="facts"><t-status kind=${kind} word=${word}></t-status>${alarm.phase === "normal" ? nothing : html`<span>${severityWords(alarm.severity)}</span><t-time short .us=${alarm.raised_us} .zone=${this.context?.zone ?? "UTC"}></t-time>`}</div>
            ${alarm.why === "" ? nothing : html`<div>${alarm.why}</div>`}
          </li>`;
        },
      )}
    </ul>`;
  }
}

@customElement("t-tile-logbook")
export class LogbookBoardTile extends LitElement {
  static override styles = [base, lists];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  /** Of one device; empty for all. */
  @property() device = "";
  @property() kind = "";
  @property({ type: Number }) lines = 20;

  @consume({ context: apiContext }) private readonly api: HubApi | undefined;
  private readonly events = new LoadController<EventList>(this);
  private readonly watched = new StoreController(this);
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor() {
    super();
    new ConnectionStateController(this, (connection) => [
      connection.onMessage("event", (news) => {
        if (news.site !== this.context?.site) return;
        // Many within a moment are one reason to load anew.
        this.timer ??= setTimeout(() => {
          this.timer = undefined;
          this.events.invalidate();
        }, REFRESH_MS);
      }),
    ]);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
    this.timer = undefined;
  }

  override willUpdate(): void {
    const { api, context } = this;
    if (api === undefined || context === null) return;
    this.watched.setStore(context.past);
    const query = new URLSearchParams({ limit: String(this.lines) });
    if (context.past !== null) query.set("to_us", String(pastTurn(context.past)));
    if (this.device !== "") query.set("device", this.device);
    if (this.kind !== "") query.set("kind", this.kind);
    const asked = query.toString();
    this.events.load(`${context.site} ${asked}`, () => new AlarmsApi(api).events(context.site, asked));
  }

  override render(): unknown {
    const zone = this.context?.zone ?? "UTC";
    return renderLoaded(this.events, msg("the logbook"), ({ events }) =>
      events.length === 0
        ? html`<p>${this.context?.past ? msg("Nothing of this kind has happened up to this moment.") : msg("Nothing of this kind has happened yet.")}</p>`
        : html`<ul aria-label=${msg("Logbook")}>
              ${repeat(
                events,
                ({ id }) => id,
                ({ time_us: time, kind, who, message, good }) => html`<li>
                  <div class="facts"><t-time short .us=${time} .zone=${zone}></t-time>${who === "" ? nothing : html`<span>${who}</span>`}</div>
                  <div>${good ? nothing : html`<t-status kind="bad" word=${msg("look")}></t-status> `}<strong>${eventWords(kind)}</strong> ${message}</div>
                </li>`,
              )}
            </ul>
            <a href=${sitePath(this.context?.site ?? "", "logbook")}>${msg("All of the logbook")}</a>`,
    );
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-alarms": AlarmsBoardTile;
    "t-tile-logbook": LogbookBoardTile;
  }
}
