/** An alarm is made or changed: what it watches, and how it would have done on the past. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { QuestionController } from "../../controllers/question.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderOptions, type SelectOption } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { AlarmsApi } from "../../wire/alarms-api.js";
import type { AnomalyList, AlarmDefinition, AlarmKind, PreviewShape, SignalShape, SiteShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { definitionOf, FIELDS, alarmFields, kindFitsType, idOf, KINDS, fieldLabel, shownHint, type AlarmField, type AlarmFields } from "./alarm-definition.js";
import { renderTrials, trialStyle, trialWindows } from "./alarm-trial.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

/** @fires t-done when it was kept, removed or left as it was */
@customElement("t-alarm-editor")
export class AlarmEditor extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    trialStyle,
  ];

  @property() site = "";
  /** Empty for a new one. */
  @property() alarm = "";
  @property({ attribute: false }) definition: AlarmDefinition | null = null;

  @state() private kind: AlarmKind | null = null;
  /** The channel that was chosen in the form; null: none yet. */
  @state() private signal: string | null = null;
  /** What was typed so far, for what is said beside it. */
  @state() private typed: AlarmFields = {};
  @state() private wrong = "";
  @state() private preview: PreviewShape | null = null;
  /** Of the settings that were tried before these, over the same stretch. */
  @state() private earlier: PreviewShape | null = null;
  @state() private hours = 24;
  @query("form") private readonly form!: HTMLFormElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly detectors = new LoadController<AnomalyList>(this);
  private readonly action = new ActionController(this);
  private readonly removing = new QuestionController<string>(this, async (alarm, action) => {
    const done = await action.run(msg("remove the alarm"), () => new AlarmsApi(this.api).removeAlarm(this.site, alarm));
    if (done) this.fireClose();
    return done;
  });

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites === undefined) return;
    const key = [this.site, sites.catalogueOf(this.site)].join("\n");
    this.detail.load(key, () => sites.loadDetail(this.site));
    this.detectors.load(key, () => this.api.anomalies(this.site));
  }

  override render(): TemplateResult {
    const fields = this.definition === null ? {} : alarmFields(this.definition);
    const kind = this.kind ?? this.definition?.kind ?? "limit";
    const signal = this.signalOf(kind, fields["signal"] ?? "");
    return html`<h2>${this.alarm === "" ? msg("New alarm") : msg("Change the alarm")}</h2>
      <form class="entry" novalidate @submit=${this.previewAlarm} @input=${this.onInput}>
        <t-field label=${msg("Name")}><input name="name" maxlength="100" autocomplete="off" .value=${fields["name"] ?? ""} /></t-field>
        <t-field label=${msg("Kind")}>
          <select name="kind" @change=${this.onChoose}>${renderOptions(KINDS.map((option) => [option.kind, option.name]), kind)}</select>
        </t-field>
        <t-field label=${msg("Severity")}>
          <select name="severity">${renderOptions(["info", "warning", "critical"], fields["severity"] ?? "warning")}</select>
        </t-field>
        ${map(
          FIELDS.filter(({ kinds }) => kinds.includes(kind)),
          (field) => html`<t-field
            class=${field.name === "expression" || field.name === "advice" ? "wide" : ""}
            label=${fieldLabel(field, signal?.unit ?? "")}
            .hint=${this.hintOf(field, signal?.states ?? []) || shownHint(field, this.typed[field.name] ?? fields[field.name] ?? "", signal)}
            .error=${this.errorOf(field.name)}
            >${this.renderControl(field.name, field.sort, fields, kind)}</t-field
          >${field.name === "expression" ? this.renderInserter() : nothing}`,
        )}
        <label class="tick wide"
          ><input type="checkbox" name="record" ?checked=${fields["record"] === "on"} /> ${msg("Record the raw topics around it")}</label
        >
        <t-field label=${msg("How far back it is tried")}
          ><select @change=${this.onWindow}>${renderOptions(trialWindows(), String(this.hours))}</select></t-field
        >
      </form>
      ${renderTrials(this.preview, this.earlier, this.sites.store?.zoneOf(this.site) ?? "UTC")}
      ${renderAdvice(this.action.problem)}
      <div class="actions">
        <t-button kind="primary" ?busy=${this.action.runningKey === "keep"} @click=${this.saveAlarm}>${msg("Keep")}</t-button>
        <t-button ?busy=${this.action.runningKey === "try"} @click=${this.previewAlarm}>${msg("Try it on the past")}</t-button>
        <t-button @click=${this.fireClose}>${msg("Cancel")}</t-button>
        ${this.alarm === "" ? nothing : html`<t-button @click=${this.removing.opener(this.alarm)}>${msg("Remove")}</t-button>`}
      </div>
      ${renderQuestion(this.removing, () => ({
        heading: msg("Remove this alarm?"),
        action: msg("Remove"),
        text: msg("It sends no more notifications. Its history stays in the logbook."),
      }))}`;
  }

  private errorOf(name: string): string {
    if (this.wrong === name) return name === "escalate" ? msg("Expected accounts with seconds: anna 0, ben 300.") : msg("Expected a number.");
    if (this.preview?.where === name || (name === "is_one_of" && this.preview?.where === "is")) return this.preview.problem ?? "";
    return "";
  }

  private hintOf(field: AlarmField, states: readonly string[]): string {
    if (field.sort === "words" && states.length > 0) return msg(str`With commas between: ${states.join(", ")}`);
    return field.hint ?? "";
  }

  /** The signal that is chosen; at first that of the definition, else the first that fits. */
  private signalOf(kind: AlarmKind, defined: string): SignalShape | undefined {
    const signals = (this.detail.value?.devices ?? []).flatMap((device) => device.signals).filter(({ type }) => kindFitsType(kind, type));
    const channelSignal = (channel: string): SignalShape | undefined => signals.find(({ address, channels }) => address === channel || channels.includes(channel));
    return channelSignal(this.signal ?? defined) ?? signals[0];
  }

  /** For who does not know the signals' addresses by heart. */
  private renderInserter(): TemplateResult {
    return html`<t-field class="wide" label=${msg("Put a signal in")}>
      <select @change=${this.insertAddress}>
        ${renderOptions([["", msg("Choose…")], ...this.channelOptions(null)], "")}
      </select>
    </t-field>`;
  }

  /** Every channel as a choice; of one kind of alarm, those that fit. */
  private channelOptions(kind: AlarmKind | null): readonly SelectOption[] {
    return (this.detail.value?.devices ?? []).flatMap(({ name, signals }) =>
      signals
        .filter(({ type }) => kind === null || kindFitsType(kind, type))
        .flatMap((signal) =>
          // A position as a whole is in a zone; elsewhere it is its parts that are watched.
          (kind === "zone" ? [signal.address] : signal.channels).map((channel) => {
            const part = kind !== "zone" && signal.channels.length > 1 ? ` ${channel.split(".").at(-1) ?? ""}` : "";
            return [channel, `${name}: ${signal.name}${part}${signal.unit === "" ? "" : ` (${signal.unit})`}`] as const;
          }),
        ),
    );
  }

  /** Groups of signals that are judged together; without the list the signals are there all the same. */
  private groupOptions(): readonly SelectOption[] {
    return (this.detectors.value?.detectors ?? []).filter(({ signals }) => signals.length > 0).map(({ address, title }) => [address, msg(str`${title}: signals together`)] as const);
  }

  private renderControl(name: string, sort: string, fields: AlarmFields, kind: AlarmKind): TemplateResult {
    const value = fields[name] ?? "";
    const devices = this.detail.value?.devices ?? [];
    if (sort === "signal") {
      const options = [...(kind === "anomaly" ? this.groupOptions() : []), ...this.channelOptions(kind)];
      return html`<select name=${name} @change=${this.onSignalChange}>${renderOptions(options, value)}</select>`;
    }
    if (sort === "device") {
      return html`<select name=${name}>${renderOptions([["", msg("No: only this signal")], ...devices.map(({ id, name: label }) => [id, label] as const)], value)}</select>`;
    }
    if (sort === "stream") {
      const streams = devices.flatMap((device) => device.streams.map(({ address, name: label }) => [address, label] as const));
      return html`<select name=${name}>${renderOptions(streams, value)}</select>`;
    }
    if (name === "expression") return html`<textarea name=${name} rows="3" maxlength="1000" spellcheck="false" .value=${value}></textarea>`;
    const shown = sort === "number" && value === "0" ? "" : value;
    return html`<input name=${name} autocomplete="off" inputmode=${sort === "number" ? "decimal" : "text"} .value=${shown} />`;
  }

  private readDefinition(): AlarmDefinition | null {
    const said: Record<string, string> = {};
    for (const [name, value] of new FormData(this.form)) if (typeof value === "string") said[name] = value;
    const found = definitionOf(said);
    this.wrong = "wrong" in found ? found.wrong : "";
    return "wrong" in found ? null : found.definition;
  }

  private readonly onChoose = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.kind = event.target.value as AlarmKind;
  };

  private readonly onSignalChange = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.signal = event.target.value;
  };

  private readonly insertAddress = (event: Event): void => {
    const area = this.form.querySelector("textarea");
    if (!(event.target instanceof HTMLSelectElement) || area === null || event.target.value === "") return;
    area.setRangeText(`{${event.target.value}}`, area.selectionStart, area.selectionEnd, "end");
    event.target.value = "";
    area.focus();
  };

  private readonly onInput = (event: Event): void => {
    const { name, value } = event.target as HTMLInputElement;
    this.typed = { ...this.typed, [name]: value };
    if (this.preview === null) return;
    // What was tried stays beside what will be, unless it could not be tried at all.
    if ((this.preview.problem ?? "") === "") this.earlier = this.preview;
    this.preview = null;
  };

  private readonly onWindow = (event: Event): void => {
    if (!(event.target instanceof HTMLSelectElement)) return;
    this.hours = Number(event.target.value);
    // Of another stretch: it says nothing beside this one.
    this.preview = this.earlier = null;
  };

  private readonly previewAlarm = (event: Event): void => {
    event.preventDefault();
    const definition = this.readDefinition();
    if (definition === null) return;
    const named = definition.name === "" ? { ...definition, name: msg("Alarm") } : definition;
    void this.action.run(
      msg("try the alarm"),
      async () => {
        this.preview = await new AlarmsApi(this.api).previewAlarm(this.site, named, this.hours);
      },
      "",
      "try",
    );
  };

  private readonly saveAlarm = (): void => {
    const definition = this.readDefinition();
    if (definition === null) return;
    const name = this.alarm === "" ? idOf(definition.name) : this.alarm;
    void this.action
      .run(msg("keep the alarm"), () => new AlarmsApi(this.api).saveAlarm(this.site, name, definition), "", "keep")
      .then((done) => {
        if (done) this.fireClose();
      });
  };

  private readonly fireClose = (): void => {
    this.dispatchEvent(new CustomEvent("t-done"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-alarm-editor": AlarmEditor;
  }
}
