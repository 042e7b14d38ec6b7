//! The tool of each section of a program.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::tool_table::{ListedTool, ToolTable};
use super::tools_at_work::ToolsAtWork;
use crate::machine::Tool;
use crate::motion::{CalledTool, StatedCutter, ToolKey, ToolLengths};
use crate::process::fault::{CutterDifference, ToolUnknown, UnfitWear};
use crate::units::Length;

/// The caller's statements about the tools of a program, without cutters.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tools {
    /// The number of the tool that the request is for. In a program of several tools the motions of the others stay
    /// unchanged.
    pub number: Option<u32>,
    /// Length of the tool. Head axes turn it.
    pub length: Option<Length>,
    /// The machine's tool table.
    pub table: Arc<ToolTable>,
    /// The program was moved for worn cutters, which replace the nominal ones.
    behind_wear: bool,
    /// By how much the control's tool lengths are shorter.
    shorter_by: Length,
    /// Which tool cuts in which section, after the program was looked through.
    by_section: Option<Arc<Tooling>>,
    /// The lengths of the tools in the spindle, after the program was looked through.
    lengths: Arc<ToolLengths>,
}

/// What the computation needs to know of a tool.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "independent needs")]
pub(in crate::process) struct Need {
    /// The shape of the cutter.
    pub(in crate::process) cutter: bool,
    /// The measured cutter, from the table.
    pub(in crate::process) worn: bool,
    /// The request states something that holds for one tool only, even if the table has the others.
    pub(in crate::process) is_for_one: bool,
    /// The request members that state a cutter.
    pub(in crate::process) stated_by: &'static str,
    /// If `CUTTER/` states another cutter than the table, the tool counts as unknown.
    pub(in crate::process) agreement: bool,
    /// Sections with unknown tools are left unchanged, even if the result does not depend on the tool.
    pub(in crate::process) leaves_unknown: bool,
}

impl Need {
    /// Only the length, and only if the machine turns the tool.
    pub(in crate::process) const LENGTH: Self = Self {
        cutter: false,
        worn: false,
        is_for_one: false,
        stated_by: "`tool_length_mm`",
        agreement: false,
        leaves_unknown: false,
    };
}

/// The known values of the tool of a section.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::process) struct ToolUsed {
    pub(in crate::process) nominal: Option<Tool>,
    /// The measured cutter, if the table has it and it is needed.
    pub(in crate::process) worn: Option<Tool>,
    pub(in crate::process) length: Option<Length>,
    /// Its place in the table, if any value comes from the table.
    pub(in crate::process) listed: Option<usize>,
    /// The worn cutter replaces the nominal one.
    takes_worn: bool,
}

/// Which tool cuts in which section.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::process) struct Tooling {
    by: By,
    /// The request names the tool by its number.
    pub(in crate::process) is_by_number: bool,
    /// The request states a cutter, but the table's cutters are used.
    pub(in crate::process) leaves_stated: bool,
    /// Cutters in the text that differ from the request's or the table's: their number, and the line of the first.
    pub(in crate::process) differing: Option<(u64, u64)>,
}

#[derive(Debug, Clone, PartialEq)]
enum By {
    /// One tool, whatever the program calls.
    All(ToolUsed),
    /// Tools by their calls.
    Sections {
        tools: BTreeMap<ToolKey, ToolUsed>,
        /// The tool used for all others; `None` if their sections are left unchanged.
        others: Option<ToolUsed>,
        /// A T word alone changes tools.
        by_t: bool,
    },
}

/// Largest difference of diameter or corner radius for two statements of the same cutter \[mm\]: the decimals of a
/// post.
const SAME_CUTTER_MM: f64 = 1e-3;

impl Tools {
    /// One tool of this length for the whole program.
    #[must_use]
    pub fn of_length(length: Option<Length>) -> Self {
        Self { length, ..Self::default() }
    }

    /// These tools on a machine with this table.
    #[must_use]
    pub fn with(number: Option<u32>, length: Option<Length>, table: Arc<ToolTable>) -> Self {
        Self { number, length, table, ..Self::default() }
    }

    /// The tools of a program that was moved for worn cutters, whose lengths in the control are shorter by
    /// `shorter_by`.
    pub(in crate::process) fn behind_wear(&self, shorter_by: Length) -> Self {
        let shorter_by = self.shorter_by + shorter_by;
        Self { behind_wear: true, shorter_by, by_section: None, ..self.clone() }
    }

    /// Which tool cuts in which section. Before the program was looked through: one tool of the stated length.
    pub(in crate::process) fn tooling(&self) -> Arc<Tooling> {
        self.by_section.clone().unwrap_or_else(|| Arc::new(Tooling::of_one(self.length)))
    }

    /// Whether the cutters that the program states are compared with the request's and the table's.
    pub(in crate::process) fn compares_cutters(&self, stated: Option<Tool>) -> bool {
        !self.behind_wear && (stated.is_some() || !self.table.is_empty())
    }

    /// The same with the tools found at work in the program. `stated` is the request's cutter.
    ///
    /// # Errors
    /// It is not known which tool cuts.
    pub(super) fn found_at_work(
        &self,
        stated: Option<Tool>,
        need: Need,
        has_head: bool,
        at_work: &ToolsAtWork,
    ) -> Result<Self, ToolUnknown> {
        let tooling = Tooling::of(self, stated, need, has_head, at_work)?;
        let lengths = Arc::new(self.lengths_in_spindle(at_work));
        Ok(Self { by_section: Some(Arc::new(tooling)), lengths, ..self.clone() })
    }

    /// The lengths of tools where the height of the spindle depends on them.
    pub(super) fn lengths(&self) -> Arc<ToolLengths> {
        Arc::clone(&self.lengths)
    }

    /// The same with every length known to the control shorter by `shorter_by`.
    pub(super) fn with_shorter(&self, shorter_by: Length) -> Self {
        let mut tooling = Tooling::clone(&self.tooling());
        tooling.each(|used| used.length = used.length.map(|length| length - shorter_by));
        Self { by_section: Some(Arc::new(tooling)), lengths: Arc::default(), ..self.clone() }
    }

    /// Whether the tools of the program's sections are known.
    pub(in crate::process) const fn are_resolved(&self) -> bool {
        self.by_section.is_some()
    }
}

impl ToolUsed {
    pub(super) fn of(given: &Tools, stated: Option<Tool>, listed: Option<(usize, &ListedTool)>) -> Self {
        let tool = listed.map(|(_, tool)| tool);
        let nominal = tool.and_then(|tool| tool.cutter).filter(|_| stated.is_none());
        let length = tool.and_then(|tool| tool.length).filter(|_| given.length.is_none());
        let worn = tool.and_then(|tool| tool.worn);
        let is_used = nominal.is_some() || length.is_some() || worn.is_some();
        Self {
            nominal: stated.or(nominal),
            worn,
            length: given.length.or(length).map(|length| length - given.shorter_by),
            listed: listed.map(|(place, _)| place).filter(|_| is_used),
            takes_worn: given.behind_wear,
        }
    }

    /// The cutter to compute with.
    pub(in crate::process) fn cutter(&self) -> Option<Tool> {
        self.worn.filter(|_| self.takes_worn).or(self.nominal)
    }

    /// Whether all needed values are known.
    fn has(&self, need: Need) -> bool {
        (!need.cutter || self.nominal.is_some()) && (!need.worn || self.worn.is_some())
    }
}

impl Tooling {
    /// One tool of this length.
    fn of_one(length: Option<Length>) -> Self {
        Self::all(ToolUsed { length, ..ToolUsed::default() })
    }

    fn all(used: ToolUsed) -> Self {
        Self { by: By::All(used), is_by_number: false, leaves_stated: false, differing: None }
    }

    /// The tool of a section; `None` if nothing is known of it.
    #[inline]
    pub(in crate::process) fn tool(&self, called: CalledTool) -> Option<ToolUsed> {
        match (&self.by, called) {
            (By::All(used), _) => Some(*used),
            (By::Sections { by_t: false, others, .. }, CalledTool::Selected(_)) => *others,
            (By::Sections { tools, others, .. }, called) => {
                called.key().and_then(|key| tools.get(&key)).copied().or(*others)
            }
        }
    }

    /// Every tool, once for each way in which it is called.
    pub(in crate::process) fn all_tools(&self) -> impl Iterator<Item = ToolUsed> {
        let (all, sections) = match &self.by {
            By::All(used) => (Some(*used), None),
            By::Sections { tools, .. } => (None, Some(tools.values().copied())),
        };
        all.into_iter().chain(sections.into_iter().flatten())
    }

    /// The only tool used, if there is only one.
    pub(in crate::process) fn only(&self) -> Option<ToolUsed> {
        match &self.by {
            By::All(used) => Some(*used),
            By::Sections { tools, .. } => {
                let mut each = tools.values();
                let first = each.next()?;
                each.all(|other| other == first).then_some(*first)
            }
        }
    }

    fn each(&mut self, mut change: impl FnMut(&mut ToolUsed)) {
        match &mut self.by {
            By::All(used) => change(used),
            By::Sections { tools, .. } => tools.values_mut().for_each(change),
        }
    }

    fn of(
        given: &Tools,
        stated: Option<Tool>,
        need: Need,
        has_head: bool,
        at_work: &ToolsAtWork,
    ) -> Result<Self, ToolUnknown> {
        let mut tooling = match given.number {
            Some(number) => Self::of_number(number, given, stated, need, at_work)?,
            None if at_work.tools.len() <= 1 => Self::of_only(given, stated, need, at_work)?,
            None => Self::by_calls(given, stated, need, has_head, at_work)?,
        };
        tooling.compare(stated, need, at_work)?;
        Ok(tooling)
    }

    /// The tool with this number. A program without tool calls runs with it. So does a program whose only tool
    /// cannot be told from its text.
    fn of_number(
        number: u32,
        given: &Tools,
        stated: Option<Tool>,
        need: Need,
        at_work: &ToolsAtWork,
    ) -> Result<Self, ToolUnknown> {
        let listed = given.table.find(ToolKey::Number(number));
        let used = ToolUsed::of(given, stated, listed);
        let tools = || format!("T{number}");
        if need.cutter && used.nominal.is_none() {
            return Err(ToolUnknown::NotListed { tools: tools(), stated: need.stated_by });
        }
        if need.worn && used.worn.is_none() {
            return Err(no_wear(given, at_work, &[CalledTool::Changed(ToolKey::Number(number))]));
        }
        if at_work.tools.iter().all(|tool| *tool == CalledTool::NotCalled)
            || matches!(at_work.tools.as_slice(), [CalledTool::Unknown(_)])
        {
            return Ok(Self::all(used));
        }
        let name = listed.and_then(|(_, tool)| tool.name.as_ref().map(crate::motion::ToolName::key));
        let keys: Vec<_> = [ToolKey::Number(number)].into_iter().chain(name).collect();
        let is_meant = |tool: &&CalledTool| tool.key().is_some_and(|key| keys.contains(&key));
        let meant: Vec<_> = at_work.tools.iter().filter(is_meant).copied().collect();
        if !meant.is_empty() && meant.iter().all(|tool| !is_put_in(*tool, at_work)) {
            return Err(not_put_in(at_work, &meant));
        }
        if meant.is_empty() {
            return Err(ToolUnknown::NoSuchTool { number, tools: names(at_work, &at_work.tools) });
        }
        let tools = keys.into_iter().map(|key| (key, used)).collect();
        let by = By::Sections { tools, others: None, by_t: by_t(at_work) };
        Ok(Self { by, is_by_number: true, leaves_stated: false, differing: None })
    }

    /// The only tool at work, called or not.
    fn of_only(
        given: &Tools,
        stated: Option<Tool>,
        need: Need,
        at_work: &ToolsAtWork,
    ) -> Result<Self, ToolUnknown> {
        let called = at_work.tools.first().and_then(|tool| tool.key());
        let used = ToolUsed::of(given, stated, called.and_then(|key| given.table.find(key)));
        if used.has(need) {
            return Ok(Self::all(used));
        }
        let tools = names(at_work, &at_work.tools);
        Err(match called {
            _ if used.nominal.is_some() || !need.cutter => no_wear(given, at_work, &at_work.tools),
            Some(_) => ToolUnknown::NotListed { tools, stated: need.stated_by },
            None if matches!(at_work.tools.as_slice(), [CalledTool::Unknown(_)]) => {
                ToolUnknown::NotTold { stated: need.stated_by }
            }
            None => ToolUnknown::Missing { stated: need.stated_by },
        })
    }

    /// The tool of each section.
    fn by_calls(
        given: &Tools,
        stated: Option<Tool>,
        need: Need,
        has_head: bool,
        at_work: &ToolsAtWork,
    ) -> Result<Self, ToolUnknown> {
        let counts_length = has_head && given.length.is_some();
        let states_one = stated.is_some() || counts_length;
        let by_t = by_t(at_work);
        let of = |tool: &CalledTool| {
            let key = tool.key().filter(|_| is_put_in(*tool, at_work))?;
            let own = Tools { length: None, ..given.clone() };
            let used = ToolUsed::of(&own, None, Some(given.table.find(key)?));
            Some((key, used))
        };
        let listed: Vec<_> = at_work.tools.iter().filter_map(of).collect();
        if need.worn && unfit_wear(given, &at_work.tools).any(|(_, why)| why.is_doubtful()) {
            return Err(no_wear(given, at_work, &at_work.tools));
        }
        if !need.cutter && !need.worn && !states_one && listed.is_empty() {
            // The result does not depend on the tool.
            return Ok(Self::of_one(given.length));
        }
        let tools: BTreeMap<_, _> = listed.iter().filter(|(_, used)| used.has(need)).copied().collect();
        if need.is_for_one || (tools.is_empty() && states_one) {
            let (count, tools) = (at_work.tools.len(), names(at_work, &at_work.tools));
            return Err(ToolUnknown::Several { count, tools, is_for_one: need.is_for_one });
        }
        if tools.is_empty() && (need.cutter || need.worn) {
            let tools = names(at_work, &at_work.tools);
            let selected: Vec<_> =
                at_work.tools.iter().filter(|tool| !is_put_in(**tool, at_work)).copied().collect();
            if listed.is_empty() && selected.iter().any(|tool| is_listed(given, *tool)) {
                return Err(not_put_in(at_work, &selected));
            }
            return Err(if need.worn && !listed.is_empty() {
                no_wear(given, at_work, &at_work.tools)
            } else {
                ToolUnknown::NotListed { tools, stated: need.stated_by }
            });
        }
        let hangs_on_tool = need.leaves_unknown || has_head;
        let others = (!hangs_on_tool).then(|| ToolUsed { length: given.length, ..ToolUsed::default() });
        let by = By::Sections { tools, others, by_t };
        Ok(Self { by, is_by_number: false, leaves_stated: states_one, differing: None })
    }

    /// Compares cutters of the text with those in use. If the table's cutter differs, it is not known which is
    /// right, and the sections of that tool are left unchanged. A cutter in the request is always used.
    fn compare(
        &mut self,
        stated: Option<Tool>,
        need: Need,
        at_work: &ToolsAtWork,
    ) -> Result<(), ToolUnknown> {
        let mut first = None;
        for found in &at_work.cutters {
            let Some(used) =
                self.tool(found.tool).filter(|used| used.nominal.is_some_and(|tool| differs(found, tool)))
            else {
                continue;
            };
            let (count, line) = self.differing.unwrap_or((0, found.line));
            self.differing = Some((count + 1, line));
            if !need.agreement || (stated.is_some() && !self.leaves_stated) {
                continue;
            }
            let fault = || differing(found, used.nominal, at_work);
            match &mut self.by {
                By::All(_) => return Err(fault()),
                By::Sections { tools, .. } => {
                    tools.retain(|_, known| *known != used);
                    first = first.or_else(|| Some(fault()));
                }
            }
        }
        match (&self.by, first) {
            (By::Sections { tools, .. }, Some(fault)) if tools.is_empty() => Err(fault),
            _ => Ok(()),
        }
    }
}

/// Those of these tools whose wear entries do not give the worn cutter.
fn unfit_wear<'a>(
    given: &'a Tools,
    tools: &'a [CalledTool],
) -> impl Iterator<Item = (CalledTool, &'a UnfitWear)> {
    tools.iter().filter_map(|tool| Some((*tool, given.table.unfit_wear(tool.key()?)?)))
}

/// Why the wear of these tools is not known.
fn no_wear(given: &Tools, at_work: &ToolsAtWork, tools: &[CalledTool]) -> ToolUnknown {
    let doubtful = unfit_wear(given, tools).find(|(_, why)| why.is_doubtful());
    match doubtful.or_else(|| unfit_wear(given, tools).next()) {
        Some((tool, why)) => ToolUnknown::UnfitWear { tool: at_work.told(tool), why: Box::new(why.clone()) },
        None => ToolUnknown::NoWear { tools: names(at_work, tools) },
    }
}

/// Whether the program puts this tool into the spindle, as far as its text shows. A T word alone does so if nothing
/// else could.
fn is_put_in(tool: CalledTool, at_work: &ToolsAtWork) -> bool {
    by_t(at_work) || !matches!(tool, CalledTool::Selected(_))
}

fn is_listed(given: &Tools, tool: CalledTool) -> bool {
    tool.key().is_some_and(|key| given.table.find(key).is_some())
}

/// The fault that only T words call these tools and do not put them in.
fn not_put_in(at_work: &ToolsAtWork, tools: &[CalledTool]) -> ToolUnknown {
    ToolUnknown::NotPutIn { tools: names(at_work, tools), by_m6: at_work.has_changer }
}

/// Whether a T word alone changes tools, because nothing else in the program could.
pub(super) fn by_t(at_work: &ToolsAtWork) -> bool {
    !at_work.has_changer && !at_work.has_calls
}

/// Whether `CUTTER/` states another cutter.
fn differs(stated: &StatedCutter, tool: Tool) -> bool {
    let off = |a: Length, b: Length| (a - b).mm().abs() > SAME_CUTTER_MM;
    let corner = stated.corner_radius.is_some_and(|corner| off(corner, tool.corner_radius()));
    corner || off(stated.diameter, tool.radius() * 2.0)
}

fn differing(stated: &StatedCutter, listed: Option<Tool>, at_work: &ToolsAtWork) -> ToolUnknown {
    let told = |diameter: Length, corner: Option<Length>| {
        let corner = corner.map(|corner| format!(" and a corner radius of {:.3} mm", corner.mm()));
        format!("a diameter of {:.3} mm{}", diameter.mm(), corner.unwrap_or_default())
    };
    ToolUnknown::CutterDiffers(Box::new(CutterDifference {
        line: stated.line,
        tool: at_work.told(stated.tool),
        stated: told(stated.diameter, stated.corner_radius),
        listed: listed.map_or_else(
            || "no cutter".to_owned(),
            |tool| told(tool.radius() * 2.0, Some(tool.corner_radius())),
        ),
    }))
}

/// Most tools listed by name.
const NAMED: usize = 20;

/// The names of these tools, for messages.
fn names(at_work: &ToolsAtWork, tools: &[CalledTool]) -> String {
    let mut text: Vec<_> = tools.iter().take(NAMED).map(|tool| at_work.told(*tool)).collect();
    if tools.len() > NAMED {
        text.push(format!("and {} more", tools.len() - NAMED));
    }
    text.join(", ")
}
