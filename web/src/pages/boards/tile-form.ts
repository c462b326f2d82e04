/** The settings of one tile, as a form that its schema makes. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { DEVICE, findSignal, findStream, signalChoices, type BoardSubjects } from "../../boards/references.js";
import { isUnset, settingFlag, settingList, settingNumber, settingText, withSetting, type SettingField, type SettingValue } from "../../boards/tile-settings.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import type { BoardTileShape, TileShape, TopicTable } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import { boardTileEntry } from "../../tiles/board/board-catalog.js";
import { TopicsApi } from "../../topics/topics-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/forms/field.js";

/** @fires t-tile the tile with the changed setting; detail is the tile */
@customElement("t-tile-form")
export class TileForm extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
      }
      fieldset {
        display: grid;
        max-block-size: 14rem;
        margin: 0;
        padding: var(--t-space-2) var(--t-space-3);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        overflow: auto;
      }
      legend {
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
      }
      label {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: 2rem;
      }
      textarea {
        min-block-size: 5rem;
        padding: var(--t-space-2);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
      }
    `,
  ];

  @property({ attribute: false }) tile: BoardTileShape | null = null;
  @property({ attribute: false }) subjects: BoardSubjects | null = null;
  @property({ attribute: false }) extensions: readonly TileShape[] = [];

  @consume({ context: apiContext }) private readonly api: HubApi | undefined;
  private readonly topics = new LoadController<TopicTable>(this);

  override willUpdate(): void {
    const { api, subjects } = this;
    const asks = boardTileEntry(this.tile?.type ?? "")?.settings.some(({ kind }) => kind === "topic") === true;
    if (asks && api !== undefined && subjects !== null) this.topics.load(subjects.detail.site, () => new TopicsApi(api, subjects.detail.site).listTopics());
  }

  override render(): TemplateResult | typeof nothing {
    const { tile, subjects } = this;
    const entry = boardTileEntry(tile?.type ?? "");
    if (tile === null || subjects === null) return nothing;
    return html`<t-field label=${msg("Title")} hint=${msg("What it shows gives the title where this is empty")}>
        <input name="title" type="text" maxlength="200" .value=${tile.title} @input=${this.onTitle} />
      </t-field>
      ${repeat(
        entry?.settings ?? [],
        ({ key }) => key,
        (field) => this.renderField(field, tile, subjects),
      )}`;
  }

  private renderField(field: SettingField, tile: BoardTileShape, subjects: BoardSubjects): TemplateResult {
    const { key, label, hint = "", kind } = field;
    if (kind === "flag") {
      const on = settingFlag(tile.settings, key, field.standard === true);
      return html`<label><input type="checkbox" name=${key} .checked=${on} @change=${this.setter(key, (input) => input.checked)} /> ${label}</label>`;
    }
    if (kind === "signals" || kind === "streams") {
      const chosen = settingList(tile.settings, key);
      const choices = [...keptChoices(field, chosen, this.choicesOf(field, subjects), subjects), ...this.choicesOf(field, subjects)];
      return html`<fieldset tabindex="-1">
        <legend>${label}${hint === "" ? nothing : ` (${hint})`}</legend>
        ${choices.length === 0 ? html`<p class="muted">${msg("There is none of this kind here.")}</p>` : nothing}
        ${map(choices, ([value, words]) => html`<label><input type="checkbox" .checked=${chosen.includes(value)} @change=${this.setter(key, (input) => (input.checked ? [...chosen, value] : chosen.filter((name) => name !== value)))} /> ${words}</label>`)}
      </fieldset>`;
    }
    const wrong = field.needed === true && isUnset(tile.settings, key) ? msg("Without it the tile has nothing to show.") : "";
    return html`<t-field label=${label} hint=${hint} error=${wrong}>${this.renderControl(field, tile, subjects)}</t-field>`;
  }

  private renderControl(field: SettingField, { settings }: BoardTileShape, subjects: BoardSubjects): TemplateResult {
    const { key, kind } = field;
    switch (kind) {
      case "number": {
        const value = settingNumber(settings, key, typeof field.standard === "number" ? field.standard : Number.NaN);
        return html`<input
          name=${key}
          type="number"
          step="any"
          min=${field.least ?? nothing}
          max=${field.most ?? nothing}
          .value=${Number.isNaN(value) ? "" : String(value)}
          @change=${this.setter(key, (input) => numberIn(input.value, field))}
        />`;
      }
      case "lines":
        return html`<textarea name=${key} maxlength="4000" .value=${settingList(settings, key).join("\n")} @change=${this.setter(key, (input) => input.value.split("\n").map((line) => line.trimEnd()).slice(0, 64))}></textarea>`;
      case "text":
        return html`<input name=${key} type="text" maxlength="200" .value=${settingText(settings, key)} @input=${this.setter(key, (input) => input.value)} />`;
      case "topic":
        return html`<input name=${key} type="text" list="topics" maxlength="200" .value=${settingText(settings, key, String(field.standard ?? ""))} @change=${this.setter(key, (input) => input.value.trim())} /><datalist id="topics">${map(this.topics.value?.topics ?? [], ({ topic }) => html`<option value=${topic}></option>`)}</datalist>`;
      case "signal":
      case "signals":
      case "device":
      case "stream":
      case "streams":
      case "command":
      case "extension":
      case "choice":
      case "flag": {
        const standard = typeof field.standard === "string" ? field.standard : "";
        const value = settingText(settings, key, standard);
        const known = this.choicesOf(field, subjects);
        // What is not here now (another robot's, or by its role) stays chosen.
        const all = value === "" || known.some(([name]) => name === value) ? known : [[value, value] as const, ...known];
        const options = standard === "" ? [["", "–"] as const, ...all] : all;
        return html`<select name=${key} @change=${this.setter(key, (input) => input.value)}>${renderOptions(options, value)}</select>`;
      }
    }
  }

  private choicesOf(field: SettingField, subjects: BoardSubjects): readonly (readonly [value: string, label: string])[] {
    const { detail } = subjects;
    switch (field.kind) {
      case "signal":
      case "signals":
        return signalChoices(subjects, field.types ?? []).map(({ value, label }) => [value, label] as const);
      case "device": {
        const fits = detail.devices.filter(({ kind }) => field.kinds === undefined || field.kinds.includes(kind));
        return [...fits.map(({ id, name }) => [id, name] as const), [DEVICE, msg("The board's device")] as const];
      }
      case "stream":
      case "streams":
        return [
          ...detail.devices.flatMap(({ name, streams }) => streams.map((stream) => [stream.address, `${name}: ${stream.name}`] as const)),
          ...ofChosenDevice(subjects.device?.streams ?? []),
          [DEVICE, msg("The first camera of the board's device")] as const,
        ];
      case "command":
        return [
          ...detail.devices.flatMap(({ id, name, commands }) => commands.map((command) => [`${id}/${command.id}`, `${name}: ${command.name}`] as const)),
          ...ofChosenDevice(subjects.device?.commands ?? []),
        ];
      case "extension":
        return this.extensions.map(({ name, title }) => [name, title] as const);
      case "choice":
        return field.options ?? [];
      case "topic":
      case "text":
      case "lines":
      case "number":
      case "flag":
        return [];
    }
  }

  private readonly onTitle = (event: Event): void => {
    if (event.target instanceof HTMLInputElement && this.tile !== null) this.fire({ ...this.tile, title: event.target.value });
  };

  private setter(key: string, read: (input: HTMLInputElement) => SettingValue): (event: Event) => void {
    return (event) => {
      const { tile } = this;
      if (tile === null) return;
      // A select and a text area have a value as an input has one.
      this.fire({ ...tile, settings: withSetting(tile.settings, key, read(event.target as HTMLInputElement)) });
    };
  }

  private fire(tile: BoardTileShape): void {
    this.dispatchEvent(new CustomEvent("t-tile", { detail: tile }));
  }
}

type TileChoice = readonly [value: string, label: string];

/** The same of whichever device is chosen, so that a board serves each of its kind. */
function ofChosenDevice(parts: readonly { readonly id: string; readonly name: string }[]): readonly TileChoice[] {
  return parts.map(({ id, name }) => [`${DEVICE}/${id}`, msg(str`${name} of the chosen device`)] as const);
}

/** What was chosen and cannot be chosen here now: by its role, of another robot, or gone. It can be taken away. */
function keptChoices({ kind }: SettingField, chosen: readonly string[], choices: readonly TileChoice[], subjects: BoardSubjects): readonly TileChoice[] {
  const find = kind === "streams" ? findStream : findSignal;
  return chosen
    .filter((name) => !choices.some(([value]) => value === name))
    .map((name) => [name, find(name, subjects) === null ? msg(str`${name} (not here)`) : name] as const);
}

/** Within the field's bounds; empty is nothing. */
function numberIn(text: string, { least = -Infinity, most = Infinity }: SettingField): SettingValue {
  const value = Number(text);
  return text.trim() === "" || !Number.isFinite(value) ? "" : Math.min(most, Math.max(least, value));
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-form": TileForm;
  }
}
