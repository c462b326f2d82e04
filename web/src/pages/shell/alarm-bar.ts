/** The bar on every page: alarms that nobody has acknowledged, the worst by name, and the sound. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base } from "../../elements/base/base-style.js";
import { plural } from "../../words/plural.js";
import { alarmsContext, alarmSoundContext, apiContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { mayUse } from "../../state/rights.js";
import { alarmPath } from "../../state/router.js";
import type { AlarmUpdate } from "../../generated/wire.js";
import { consume } from "@lit/context";
import type { HubApi } from "../../wire/hub-api.js";
import { AlarmsApi } from "../../wire/alarms-api.js";
import { ActionController } from "../../controllers/action.js";
import "../../elements/forms/button.js";
import "../../elements/base/icon.js";
import "../../elements/values/time.js";

@customElement("t-alarm-bar")
export class AlarmBar extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      .bar {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-3);
        padding: var(--t-space-1) var(--t-space-4);
        border-block-end: 1px solid var(--t-line);
        border-inline-start: 6px solid var(--t-warn);
        background: var(--t-raised);
      }
      .bar.critical {
        border-inline-start-color: var(--t-bad);
      }
      .bar.info {
        border-inline-start-color: var(--t-info);
      }
      t-icon {
        color: var(--t-warn);
      }
      .critical t-icon {
        color: var(--t-bad);
      }
      .info t-icon {
        color: var(--t-info);
      }
      .what {
        flex: 1 1 14rem;
        min-inline-size: 0;
        overflow-wrap: anywhere;
      }
      .more,
      .undelivered {
        font-size: var(--t-size-s);
      }
      .more {
        color: var(--t-muted);
      }
      .undelivered {
        color: var(--t-bad);
        font-weight: var(--t-weight-strong);
      }
      a.which {
        color: inherit;
        font-weight: var(--t-weight-strong);
      }
      a.all {
        display: inline-flex;
        align-items: center;
        min-block-size: var(--t-touch);
        font-weight: var(--t-weight-strong);
      }
      .actions {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-2);
      }
    `,
  ];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly alarms = new ContextStoreController(this, alarmsContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sound = new ContextStoreController(this, alarmSoundContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly action = new ActionController(this);

  constructor() {
    super();
    // A shelf's end comes by itself.
    new TickerController(this, 1000);
  }

  override render(): TemplateResult | typeof nothing {
    const summary = this.alarms.store?.summary;
    const worst = summary?.unseen[0] ?? summary?.undelivered[0];
    if (summary === undefined || worst === undefined) return nothing;
    const { unseen, undelivered } = summary;
    const sound = this.sound.store;
    return html`<div class="bar ${worst.severity}" role="region" aria-label=${msg("Alarms")}>
      <t-icon name="bell"></t-icon>
      <span class="what" role=${worst.severity === "critical" ? "alert" : "status"}>${this.renderMessage(worst)}</span>
      ${unseen.length > 1 ? html`<span class="more">${msg(str`and ${unseen.length - 1} more`)}</span>` : nothing}
      ${undelivered.length === 0
        ? nothing
        : html`<span class="undelivered">${plural(undelivered.length, msg("A message could not be delivered"), msg("Messages could not be delivered"))}</span>`}
      ${sound?.isOn === true && !sound.isAudible ? html`<span class="more">${msg("silent until you click or press a key")}</span>` : nothing}
      ${this.action.problem === null ? nothing : html`<span class="undelivered" role="alert">${this.action.problem.what}</span>`}
      <span class="actions">
        ${unseen.length > 0 && mayUse(this.session.store?.person, worst.site, worst.device)
          ? html`<t-button label=${msg(str`Acknowledge ${worst.name}`)} ?busy=${this.action.busy} @click=${this.acknowledge}
              >${msg("Acknowledge")}</t-button
            >`
          : nothing}
        <t-button kind="quiet" @click=${this.toggleSound}>${sound?.isOn === true ? msg("Mute") : msg("Turn sound on")}</t-button>
        <a class="all" href="/alarms" aria-label=${msg("All alarms")}>${msg("All", { id: "all.alarms" })}</a>
      </span>
    </div>`;
  }

  private renderMessage(alarm: AlarmUpdate): TemplateResult {
    const row = this.sites.store?.siteRow(alarm.site);
    const many = (this.sites.store?.list.length ?? 0) > 1;
    return html`<a class="which" href=${alarmPath(alarm)}>${many ? `${row?.name ?? alarm.site}: ` : ""}${alarm.name}</a> – ${alarm.why}
      <span class="more"
        >${alarm.phase === "cleared" ? msg(html`over, not acknowledged; since <t-time .us=${alarm.raised_us} .zone=${row?.zone ?? "UTC"} short></t-time
      >`) : msg(html`since <t-time .us=${alarm.raised_us} .zone=${row?.zone ?? "UTC"} short></t-time
      >`)}</span>`;
  }

  private readonly acknowledge = (): void => {
    const worst = this.alarms.store?.summary.unseen[0];
    if (worst === undefined) return;
    void this.action.run(msg("acknowledge the alarm"), () =>
      new AlarmsApi(this.api).applyAction(worst.site, worst.alarm, { act: "acknowledge" }),
    );
  };

  private readonly toggleSound = (): void => {
    this.sound.store?.setOn(!this.sound.store.isOn);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-alarm-bar": AlarmBar;
  }
}
