/** Every alarm that is open to the person: how it stands, what to do about it, and what has been. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { severityWords } from "../../format/severity.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { boardAtPath } from "../../boards/board-query.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { plural } from "../../words/plural.js";
import type { AlarmUpdate } from "../../generated/wire.js";
import { alarmsContext, alarmSoundContext, apiContext, routerContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import { AlarmsApi } from "../../wire/alarms-api.js";
import type { AlarmList, AlarmShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { historyAt, alarmStatus } from "../../elements/feedback/alarm-labels.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/dialog.js";
import { causeQuery } from "../cause/cause-words.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/field.js";
import "../../elements/feedback/status.js";
import "../../elements/analysis/signal-shares.js";
import "../../elements/values/time.js";
import "./alarm-editor.js";
import "./alarm-history.js";

type AlarmAction = "assign" | "comment" | "shelve";

const QUESTIONS: Readonly<Record<AlarmAction, readonly [heading: string, label: string, action: string, asked: string]>> = {
  assign: [msg("Who sees to it?"), msg("Name of the person (empty: nobody)"), msg("Assign"), msg("assign the alarm")],
  comment: [msg("Say something about it"), msg("Comment", { id: "comment.noun" }), msg("Keep"), msg("keep the comment")],
  shelve: [msg("Put it aside for a while"), msg("Why"), msg("Shelve"), msg("shelve the alarm")],
};

const SHELVE_HOURS = [["0.5", msg("half an hour")], ["1", msg("1 hour")], ["8", msg("8 hours")], ["24", msg("1 day")], ["168", msg("7 days")]] as const;

@customElement("t-page-alarms")
export class PageAlarms extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    css`
      li.alarm {
        border-inline-start: 5px solid var(--t-line);
        padding-inline-start: var(--t-space-3);
      }
      li.named {
        outline: 2px solid var(--t-accent);
        outline-offset: 2px;
        scroll-margin-block: 40vh;
      }
      li.on.warning {
        border-inline-start-color: var(--t-warn);
      }
      li.on.critical {
        border-inline-start-color: var(--t-bad);
      }
      li.on.info {
        border-inline-start-color: var(--t-info);
      }
      .why,
      .advice {
        overflow-wrap: anywhere;
      }
      t-signal-shares {
        display: block;
        margin-block: var(--t-space-2);
      }
      .undelivered {
        color: var(--t-bad);
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
        overflow-wrap: anywhere;
      }
      .facts a {
        font-weight: var(--t-weight-strong);
      }
      t-alarm-past,
      t-alarm-editor {
        grid-column: 1 / -1;
      }
      @media (min-width: 45.01rem) {
        li .actions {
          justify-content: end;
          max-inline-size: 26rem;
        }
      }
    `,
  ];

  @state() private open = "";
  @query("li.named") private readonly row!: HTMLElement | null;
  @query("#text") private readonly text!: HTMLInputElement | null;
  @query("#hours") private readonly hours!: HTMLSelectElement | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly alarms = new ContextStoreController(this, alarmsContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sound = new ContextStoreController(this, alarmSoundContext);
  private readonly router = new ContextStoreController(this, routerContext);
  /** The alarm that the address named last, and that was shown for it. */
  private shownFor = "";
  private readonly defined = new LoadController<ReadonlyMap<string, AlarmList>>(this);
  private readonly action = new ActionController(this);
  private readonly doing = new OpenSubject<{ readonly what: AlarmAction; readonly about: AlarmUpdate }>(this);
  /** Site and alarm that is being changed, or a site and nothing for a new one. */
  private readonly editor = new OpenSubject<{ readonly site: string; readonly alarm: string }>(this);

  constructor() {
    super();
    new TickerController(this, 1000);
  }

  override willUpdate(): void {
    const sites = (this.sites.store?.list ?? []).map(({ site }) => site);
    // What is defined changes when an alarm comes or goes.
    const names = (this.alarms.store?.list ?? []).map((alarm) => `${alarm.site}/${alarm.alarm}/${alarm.name}`).sort();
    this.defined.load([...sites, ...names].join("\n"), async () => {
      const api = new AlarmsApi(this.api);
      return new Map(await Promise.all(sites.map(async (site) => [site, await api.listAlarms(site)] as const)));
    });
  }

  /** Brings the alarm into view that the address names: a message or the bar led here. */
  override updated(): void {
    const named = this.addressedAlarm();
    if (named === this.shownFor) return;
    const { row } = this;
    if (named !== "" && row === null) return;
    this.shownFor = named;
    if (row === null) return;
    this.open = named;
    row.scrollIntoView({ block: "center" });
    row.focus({ preventScroll: true });
  }

  /** Site and alarm that the address names; empty: none. */
  private addressedAlarm(): string {
    return new URLSearchParams(this.router.store?.search ?? "").get("alarm") ?? "";
  }

  override render(): TemplateResult {
    const list = this.alarms.store?.list ?? [];
    const manageable = [...(this.defined.value ?? [])].filter(([, one]) => one.may_manage).map(([site]) => site);
    const editing = this.editor.subject;
    return html`${renderPageHead(
        msg("Alarms"),
        html`<span role="status">${this.countText(list)}</span>`,
        html`<div class="actions">
          <t-button pressed=${this.sound.store?.isOn === true ? "true" : "false"} @click=${this.toggleSound}>${msg("Sound")}</t-button>
          ${map(
            this.sites.store?.list ?? [],
            ({ site, name }) => html`<a href=${sitePath(site, "logbook")}>${msg(str`Logbook of ${name}`)}</a>`,
          )}
          ${map(
            manageable,
            (site) => html`<t-button @click=${this.editor.opener({ site, alarm: "" })}
              >${manageable.length > 1 ? msg(str`New alarm of ${this.sites.store?.siteRow(site)?.name ?? site}`) : msg("New alarm")}</t-button
            >`,
          )}
        </div>`,
      )}
      ${renderAdvice(this.action.problem)}
      ${editing?.alarm === ""
        ? html`<section class="sheet"><t-alarm-editor .site=${editing.site} @t-done=${this.onAlarmSaved}></t-alarm-editor></section>`
        : nothing}
      ${list.length === 0 || this.defined.result.state === "failed" ? renderLoaded(this.defined, msg("the alarms"), () => renderEmpty(list)) : nothing}
      ${list.length === 0 ? nothing : this.renderSheet(list)} ${this.renderDialog()}`;
  }

  private countText(list: readonly AlarmUpdate[]): string {
    const on = list.filter(({ phase }) => phase === "active" || phase === "acknowledged").length;
    const unknown = list.filter(({ known, phase }) => !known && phase === "normal").length;
    if (list.length === 0) return "";
    const all = String(list.length);
    const active = plural(on, msg(str`1 is active of ${all}`), msg(str`${String(on)} are active of ${all}`));
    return unknown === 0 ? `${active}.` : msg(str`${active}; ${String(unknown)} cannot be judged now.`);
  }

  private renderSheet(list: readonly AlarmUpdate[]): TemplateResult {
    return html`<section class="sheet" aria-label=${msg("Every alarm")}>
      <ul class="rows">
        ${repeat(
          list,
          (alarm) => `${alarm.site}/${alarm.alarm}`,
          (alarm) => this.renderLine(alarm),
        )}
      </ul>
    </section>`;
  }

  private shapeOf(news: AlarmUpdate): AlarmShape | undefined {
    return this.defined.value?.get(news.site)?.alarms.find(({ alarm }) => alarm === news.alarm);
  }

  private renderLine(alarm: AlarmUpdate): TemplateResult {
    const row = this.sites.store?.siteRow(alarm.site);
    const zone = row?.zone ?? "UTC";
    const [kind, word] = alarmStatus(alarm, this.alarms.store?.isShelved(alarm) ?? false);
    const on = alarm.phase === "active" || alarm.phase === "acknowledged" ? "on" : "";
    const many = (this.sites.store?.list.length ?? 0) > 1;
    const id = `${alarm.site}/${alarm.alarm}`;
    const named = id === this.addressedAlarm();
    return html`<li class="alarm ${alarm.severity} ${on} ${named ? "named" : ""}" data-alarm=${alarm.alarm} tabindex=${named ? "-1" : nothing} aria-current=${named ? "true" : nothing}>
      <div>
        <div class="facts"><t-status kind=${kind} word=${word}></t-status>${alarm.phase === "normal" && alarm.known ? nothing : html`<span class="chip">${severityWords(alarm.severity)}</span>`}</div>
        <div class="name">${many ? `${row?.name ?? alarm.site}: ` : ""}${alarm.name}</div>
        ${alarm.why === "" ? nothing : html`<div class="why">${alarm.why}</div>`}
        ${alarm.shares.length < 2
          ? nothing
          : html`<t-signal-shares .shares=${alarm.shares} .labels=${new Map(alarm.shares.map(({ signal, name }) => [signal, name]))}></t-signal-shares>`}
        ${alarm.known ? nothing : html`<div class="why">${msg("It cannot be judged now:")} ${capitalized(alarm.unknown_why)}</div>`}
        ${alarm.advice === "" || on === "" ? nothing : html`<div class="advice"><strong>${msg("What to do:")}</strong> ${alarm.advice}</div>`}
        ${alarm.undelivered === "" ? nothing : html`<div class="undelivered">${msg("Could not be delivered:")} ${alarm.undelivered}</div>`}
        <div class="facts">
          ${alarm.raised_us === 0 ? nothing : html`<span>${msg(html`raised <t-time .us=${alarm.raised_us} .zone=${zone}></t-time>`)}</span>`}
          ${alarm.cleared_us === 0 ? nothing : html`<span>${msg(html`over <t-time .us=${alarm.cleared_us} .zone=${zone}></t-time>`)}</span>`}
          ${alarm.acked_by === "" ? nothing : html`<span>${msg(str`acknowledged by ${alarm.acked_by}`)}</span>`}
          ${alarm.assigned === "" ? nothing : html`<span>${msg(str`${alarm.assigned} sees to it`)}</span>`}
          ${this.alarms.store?.isShelved(alarm) === true
            ? html`<span>${msg(html`shelved by ${alarm.shelved_by} until <t-time .us=${alarm.shelved_until_us} .zone=${zone}></t-time>${alarm.shelved_why === "" ? "" : `: ${alarm.shelved_why}`}`)}</span>`
            : nothing}
          ${alarm.raised_us === 0 || alarm.signals.length === 0 ? nothing : html`<a href=${historyAt(alarm)}>${msg("Chart")}</a>`}
          ${alarm.raised_us === 0 ? nothing : html`<a href=${`${sitePath(alarm.site, "cause")}?${causeQuery(alarm.raised_us)}`}>${msg("Cause")}</a>`}
          ${alarm.raised_us === 0 ? nothing : html`<a href=${boardAtPath(alarm.site, alarm.raised_us)} title=${msg("See the board at that moment")}>${msg("Board then")}</a>`}
        </div>
      </div>
      ${this.renderButtons(alarm)}
      ${this.open === id ? html`<t-alarm-past .site=${alarm.site} .alarm=${alarm.alarm} .zone=${zone} .turn=${alarm.phase}></t-alarm-past>` : nothing}
      ${this.isEdited(alarm)
        ? html`<t-alarm-editor
            .site=${alarm.site}
            .alarm=${alarm.alarm}
            .definition=${this.shapeOf(alarm)?.definition ?? null}
            @t-done=${this.onAlarmSaved}
          ></t-alarm-editor>`
        : nothing}
    </li>`;
  }

  private renderButtons(alarm: AlarmUpdate): TemplateResult {
    const may = this.shapeOf(alarm)?.may_use === true;
    const manage = alarm.made && this.defined.value?.get(alarm.site)?.may_manage === true;
    const unseen = alarm.phase === "active" || alarm.phase === "cleared";
    const shelved = this.alarms.store?.isShelved(alarm) === true;
    const id = `${alarm.site}/${alarm.alarm}`;
    const open = this.open === id;
    // Of what is well there is little to do: a long list of it stays short.
    const more = open || shelved || alarm.phase !== "normal";
    return html`<div class="actions">
      ${may && unseen
        ? html`<t-button kind="primary" label=${msg(str`Acknowledge ${alarm.name}`)} ?busy=${this.action.runningKey === id} @click=${this.acknowledgeAsker(alarm)}
            >${msg("Acknowledge")}</t-button
          >`
        : nothing}
      ${may && more
        ? html`<t-button label=${msg(str`Assign ${alarm.name}`)} @click=${this.dialogOpener("assign", alarm)}>${msg("Assign")}</t-button>
            <t-button label=${msg(str`Comment on ${alarm.name}`)} @click=${this.dialogOpener("comment", alarm)}>${msg("Comment")}</t-button>
            ${shelved
              ? html`<t-button label=${msg(str`Unshelve ${alarm.name}`)} @click=${this.unshelveAction(alarm)}>${msg("Unshelve")}</t-button>`
              : html`<t-button label=${msg(str`Shelve ${alarm.name}`)} @click=${this.dialogOpener("shelve", alarm)}>${msg("Shelve")}</t-button>`}`
        : nothing}
      <t-button label=${msg(str`More about ${alarm.name}`)} pressed=${open ? "true" : "false"} @click=${this.detailsToggler(id)}>${msg("More")}</t-button>
      ${manage && (more || !alarm.known) ? html`<t-button label=${msg(str`Change ${alarm.name}`)} @click=${this.editorOpener(alarm)}>${msg("Change")}</t-button>` : nothing}
    </div>`;
  }

  private renderDialog(): TemplateResult {
    const { subject, isOpen, close } = this.doing;
    const what = subject?.what;
    const [heading, label, action] = QUESTIONS[what ?? "comment"];
    return html`<t-dialog heading=${heading} ?open=${isOpen} @t-close=${close}>
      <form novalidate @submit=${this.onSubmit}>
        <p>${subject?.about.name ?? ""}</p>
        <t-field label=${label}>
          <input id="text" type="text" maxlength=${what === "assign" ? "200" : "1000"} autocomplete="off" />
        </t-field>
        ${what === "assign" ? html`<t-button @click=${this.openOwnRules}>${msg("Myself")}</t-button>` : nothing}
        ${what === "shelve"
          ? html`<t-field label=${msg("For")} hint=${msg("It is listed separately and sends no notifications meanwhile.")}>
              <select id="hours">
                ${renderOptions(SHELVE_HOURS, "1")}
              </select>
            </t-field>`
          : nothing}
        ${renderAdvice(this.action.problem)}
      </form>
      <t-button slot="actions" @click=${close}>${msg("Cancel")}</t-button>
      <t-button slot="actions" kind="primary" ?busy=${this.action.busy} @click=${this.onSubmit}>${action}</t-button>
    </t-dialog>`;
  }

  private acknowledgeAsker(alarm: AlarmUpdate): () => void {
    return () => {
      void this.action.run(
        msg("acknowledge the alarm"),
        () => new AlarmsApi(this.api).applyAction(alarm.site, alarm.alarm, { act: "acknowledge" }),
        "",
        `${alarm.site}/${alarm.alarm}`,
      );
    };
  }

  private unshelveAction(alarm: AlarmUpdate): () => void {
    return () => {
      void this.action.run(msg("unshelve the alarm"), () => new AlarmsApi(this.api).applyAction(alarm.site, alarm.alarm, { act: "unshelve" }));
    };
  }

  private dialogOpener(what: AlarmAction, about: AlarmUpdate): () => void {
    return () => {
      this.action.clear();
      if (this.text) this.text.value = what === "assign" ? about.assigned : "";
      this.doing.open({ what, about });
    };
  }

  private detailsToggler(id: string): () => void {
    return () => {
      this.open = this.open === id ? "" : id;
    };
  }

  private isEdited({ site, alarm }: AlarmUpdate): boolean {
    return this.editor.subject?.site === site && this.editor.subject.alarm === alarm;
  }

  private editorOpener(alarm: AlarmUpdate): (event: Event) => void {
    return this.isEdited(alarm) ? this.editor.close : this.editor.opener({ site: alarm.site, alarm: alarm.alarm });
  }

  private readonly toggleSound = (): void => {
    this.sound.store?.setOn(!this.sound.store.isOn);
  };

  private readonly onAlarmSaved = (): void => {
    this.editor.close();
    this.defined.invalidate();
  };

  private readonly openOwnRules = (): void => {
    if (this.text) this.text.value = this.session.store?.person?.name ?? "";
  };

  private readonly onSubmit = (event: Event): void => {
    event.preventDefault();
    const doing = this.doing.subject;
    if (doing === null) return;
    const text = this.text?.value.trim() ?? "";
    const { site, alarm } = doing.about;
    const until = Math.round((Date.now() + Number(this.hours?.value ?? 1) * 3_600_000) * 1000);
    const asked = { act: doing.what, ...(doing.what === "assign" ? { to: text } : { text }), ...(doing.what === "shelve" ? { until_us: until } : {}) };
    void this.action.run(QUESTIONS[doing.what][3], () => new AlarmsApi(this.api).applyAction(site, alarm, asked)).then((done) => {
      // Another question may have been opened while the hub was asked.
      if (done && this.doing.subject === doing) this.doing.close();
    });
  };
}

function renderEmpty(list: readonly AlarmUpdate[]): TemplateResult | typeof nothing {
  if (list.length > 0) return nothing;
  return html`<t-empty heading=${msg("There are no alarms yet")} icon="bell">
    <p>${msg(html`The site description can have some under <code>alarms:</code>, and whoever manages a site can make more here.`)}</p>
  </t-empty>`;
}

function capitalized(text: string): string {
  return /[.?!]$/.test(text) ? text : `${text}.`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-alarms": PageAlarms;
  }
}
