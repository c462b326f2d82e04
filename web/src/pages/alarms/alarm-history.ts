/** What has happened to one alarm, newest first. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { alarmWords } from "../../format/kinds/event-kinds.js";
import { boardAtPath } from "../../boards/board-query.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { apiContext } from "../../state/contexts.js";
import { AlarmsApi } from "../../wire/alarms-api.js";
import type { AlarmPastList } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/values/time.js";

@customElement("t-alarm-past")
export class AlarmHistoryView extends LitElement {
  static override styles = [
    base,
    css`
      ol {
        display: grid;
        gap: var(--t-space-1);
        margin: 0;
        padding: var(--t-space-2) 0 0;
        list-style: none;
        font-size: var(--t-size-s);
      }
      li {
        overflow-wrap: anywhere;
      }
    `,
  ];

  @property() site = "";
  @property() alarm = "";
  @property() zone = "UTC";
  /** Asked anew when this changes. */
  @property() turn = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly past = new LoadController<AlarmPastList>(this);

  override willUpdate(): void {
    this.past.load([this.site, this.alarm, this.turn].join("\n"), () => new AlarmsApi(this.api).alarmHistory(this.site, this.alarm));
  }

  override render(): unknown {
    return renderLoaded(this.past, msg("the alarm's history"), (value) => this.renderHistory(value));
  }

  private renderHistory(value: AlarmPastList): TemplateResult {
    if (value.past.length === 0) return html`<p class="muted">${msg("It has never been raised, and it has no notes.")}</p>`;
    return html`<ol>
        ${map(
          value.past,
          (event) => html`<li>
            <t-time .us=${event.time_us} .zone=${this.zone}></t-time>
            <strong>${alarmWords(event.what)}</strong>${event.who === "" ? "" : msg(str` by ${event.who}`)}${event.message === "" ? "" : `: ${event.message}`}
            <a href=${boardAtPath(this.site, event.time_us)} title=${msg("See the board at that moment")}>${msg("Board then")}</a>
          </li>`,
        )}
      </ol>
      ${value.more ? html`<p class="muted">${msg("Earlier entries are in the logbook.")}</p>` : nothing}`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-alarm-past": AlarmHistoryView;
  }
}
