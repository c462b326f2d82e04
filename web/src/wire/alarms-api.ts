/** What may be asked of the hub about alarms, who is told of them, and what has happened. */

import type {
  ActAsk,
  AlarmDefinition,
  AlarmList,
  AlarmPastList,
  EventList,
  ExtensionList,
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

export class AlarmsApi {
  constructor(private readonly hub: Pick<HubApi, "request">) {}

  listAlarms(site: string): Promise<AlarmList> {
    return this.hub.request("GET", alarmUrl(site));
  }

  alarmHistory(site: string, alarm: string, before = ""): Promise<AlarmPastList> {
    const query = before === "" ? "" : `?before=${encodeURIComponent(before)}`;
    return this.hub.request("GET", `${alarmUrl(site, alarm)}/history${query}`);
  }

  async applyAction(site: string, alarm: string, asked: ActAsk): Promise<void> {
    await this.hub.request("POST", `${alarmUrl(site, alarm)}/act`, asked);
  }

  async saveAlarm(site: string, alarm: string, definition: AlarmDefinition): Promise<void> {
    await this.hub.request("PUT", alarmUrl(site, alarm), definition);
  }

  async removeAlarm(site: string, alarm: string): Promise<void> {
    await this.hub.request("DELETE", alarmUrl(site, alarm));
  }

  previewAlarm(site: string, definition: AlarmDefinition, hours = 24): Promise<PreviewShape> {
    return this.hub.request("POST", `/api/sites/${encodeURIComponent(site)}/alarm-preview`, { definition, hours });
  }

  /** @param query what is asked for, as the hub reads it */
  events(site: string, query: string): Promise<EventList> {
    return this.hub.request("GET", `/api/sites/${encodeURIComponent(site)}/events?${query}`);
  }
}

export class NotifyApi {
  constructor(private readonly hub: Pick<HubApi, "request">) {}

  listChannels(): Promise<WayList> {
    return this.hub.request("GET", "/api/ways");
  }

  async saveChannel(id: string, way: WayAsk): Promise<void> {
    if (id === "") await this.hub.request("POST", "/api/ways", way);
    else await this.hub.request("PUT", `/api/ways/${encodeURIComponent(id)}`, way);
  }

  async removeChannel(id: string): Promise<void> {
    await this.hub.request("DELETE", `/api/ways/${encodeURIComponent(id)}`);
  }

  testChannel(id: string): Promise<WentShape> {
    return this.hub.request("POST", `/api/ways/${encodeURIComponent(id)}/test`, {});
  }

  /** What other packages bring to the hub, and what of it is broken. */
  listExtensions(): Promise<ExtensionList> {
    return this.hub.request("GET", "/api/extensions");
  }

  channelChoices(): Promise<WayChoiceList> {
    return this.hub.request("GET", "/api/me/ways");
  }

  rules(): Promise<RuleList> {
    return this.hub.request("GET", "/api/me/rules");
  }

  /** @param id of the rule that is changed; empty for a new one */
  async saveRule(id: string, rule: RuleAsk): Promise<void> {
    if (id === "") await this.hub.request("POST", "/api/me/rules", rule);
    else await this.hub.request("PUT", `/api/me/rules/${encodeURIComponent(id)}`, rule);
  }

  async removeRule(id: string): Promise<void> {
    await this.hub.request("DELETE", `/api/me/rules/${encodeURIComponent(id)}`);
  }

  testRule(id: string): Promise<WentShape> {
    return this.hub.request("POST", `/api/me/rules/${encodeURIComponent(id)}/test`, {});
  }

  pushSubscriptions(): Promise<PushList> {
    return this.hub.request("GET", "/api/me/push");
  }

  async addBrowser(asked: PushAsk): Promise<void> {
    await this.hub.request("POST", "/api/me/push", asked);
  }

  async removeBrowser(id: string): Promise<void> {
    await this.hub.request("DELETE", `/api/me/push/${encodeURIComponent(id)}`);
  }
}

function alarmUrl(site: string, alarm = ""): string {
  const tail = alarm === "" ? "" : `/${encodeURIComponent(alarm)}`;
  return `/api/sites/${encodeURIComponent(site)}/alarms${tail}`;
}
