/** What may be asked of the hub about alarms, who is told of them, and what has happened. */

import type {
  ActAsk,
  AlarmDefinition,
  AlarmList,
  AlarmPastList,
  EventList,
  PreviewShape,
  PushAsk,
  PushList,
  RuleAsk,
  RuleList,
  WayAsk,
  WayChoiceList,
  WayList,
  WentShape,
} from "../generated/api.js";
import type { HubApi } from "./hub-api.js";

export type {
  AlarmDefinition,
  AlarmList,
  AlarmPast,
  AlarmPastList,
  AlarmShape,
  EventList,
  EventShape,
  PreviewShape,
  PushList,
  RuleAsk,
  NoticeRuleShape,
  WayAsk,
  WayChoice,
  WayShape,
  WentShape,
} from "../generated/api.js";

export class AlarmsApi {
  constructor(private readonly hub: Pick<HubApi, "ask">) {}

  list(site: string): Promise<AlarmList> {
    return this.hub.ask("GET", at(site));
  }

  past(site: string, alarm: string, before = ""): Promise<AlarmPastList> {
    const query = before === "" ? "" : `?before=${encodeURIComponent(before)}`;
    return this.hub.ask("GET", `${at(site, alarm)}/history${query}`);
  }

  async act(site: string, alarm: string, asked: ActAsk): Promise<void> {
    await this.hub.ask("POST", `${at(site, alarm)}/act`, asked);
  }

  async define(site: string, alarm: string, definition: AlarmDefinition): Promise<void> {
    await this.hub.ask("PUT", at(site, alarm), definition);
  }

  async remove(site: string, alarm: string): Promise<void> {
    await this.hub.ask("DELETE", at(site, alarm));
  }

  preview(site: string, definition: AlarmDefinition, hours = 24): Promise<PreviewShape> {
    return this.hub.ask("POST", `/api/sites/${encodeURIComponent(site)}/alarm-preview`, { definition, hours });
  }

  /** @param query what is asked for, as the hub reads it */
  events(site: string, query: string): Promise<EventList> {
    return this.hub.ask("GET", `/api/sites/${encodeURIComponent(site)}/events?${query}`);
  }
}

export class NotifyApi {
  constructor(private readonly hub: Pick<HubApi, "ask">) {}

  ways(): Promise<WayList> {
    return this.hub.ask("GET", "/api/ways");
  }

  async putWay(id: string, way: WayAsk): Promise<void> {
    if (id === "") await this.hub.ask("POST", "/api/ways", way);
    else await this.hub.ask("PUT", `/api/ways/${encodeURIComponent(id)}`, way);
  }

  async removeWay(id: string): Promise<void> {
    await this.hub.ask("DELETE", `/api/ways/${encodeURIComponent(id)}`);
  }

  testWay(id: string): Promise<WentShape> {
    return this.hub.ask("POST", `/api/ways/${encodeURIComponent(id)}/test`, {});
  }

  choices(): Promise<WayChoiceList> {
    return this.hub.ask("GET", "/api/me/ways");
  }

  rules(): Promise<RuleList> {
    return this.hub.ask("GET", "/api/me/rules");
  }

  /** @param id of the rule that is changed; empty for a new one */
  async putRule(id: string, rule: RuleAsk): Promise<void> {
    if (id === "") await this.hub.ask("POST", "/api/me/rules", rule);
    else await this.hub.ask("PUT", `/api/me/rules/${encodeURIComponent(id)}`, rule);
  }

  async removeRule(id: string): Promise<void> {
    await this.hub.ask("DELETE", `/api/me/rules/${encodeURIComponent(id)}`);
  }

  testRule(id: string): Promise<WentShape> {
    return this.hub.ask("POST", `/api/me/rules/${encodeURIComponent(id)}/test`, {});
  }

  push(): Promise<PushList> {
    return this.hub.ask("GET", "/api/me/push");
  }

  async addBrowser(asked: PushAsk): Promise<void> {
    await this.hub.ask("POST", "/api/me/push", asked);
  }

  async removeBrowser(id: string): Promise<void> {
    await this.hub.ask("DELETE", `/api/me/push/${encodeURIComponent(id)}`);
  }
}

function at(site: string, alarm = ""): string {
  const tail = alarm === "" ? "" : `/${encodeURIComponent(alarm)}`;
  return `/api/sites/${encodeURIComponent(site)}/alarms${tail}`;
}
