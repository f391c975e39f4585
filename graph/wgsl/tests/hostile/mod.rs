//! Files whose names and formatting are as unkind to a linker as WGSL allows.
//!
//! Two files of a pair declare the same names, names of the language and of the library, and names as a linker would
//! make them. Members, parameters and local variables have names of declarations. Tokens stand on one line or on many,
//! with comments between them. Each imports a file `shared.wgsl` of its own and has a loop. The tame form of a pair
//! computes the same with names that nothing else has.

pub mod bombs;

/// The two files of a pair, `one.wgsl` and `two.wgsl`.
pub struct Pair {
    /// Files with unkind names.
    pub hostile: [Kernel; 2],
    /// Files that compute the same with names of their own.
    pub tame: [Kernel; 2],
}

/// A file with one kernel function.
pub struct Kernel {
    /// The text of the file.
    pub text: String,
    /// The name of the function.
    pub function: String,
    /// The name of its only argument.
    pub argument: &'static str,
    /// The text of the file `shared.wgsl` that it imports.
    pub shared: String,
}

/// Names that declarations, members, parameters and local variables share.
const NAMES: [&str; 44] = [
    "helper",
    "gain",
    "length",
    "dot",
    "mix",
    "max",
    "abs",
    "clamp",
    "select",
    "tap",
    "texel",
    "sanitized",
    "between",
    "luminance",
    "size",
    "uv",
    "pixel",
    "source",
    "params",
    "at",
    "run",
    "compute",
    "fragment",
    "vertex",
    "kernel0",
    "kernel1",
    "value0",
    "image0",
    "result0",
    "PassUniform",
    "Frame",
    "one_helper",
    "two_helper",
    "one_gain",
    "two_gain",
    "point_at",
    "power",
    "sanitize",
    "sin",
    "shared_help",
    "is_last_step",
    "begin_steps",
    "steps_left",
    "loops_is_last_step",
];

/// Builtin functions that a file uses where it does not declare them.
const BUILTINS: [&str; 4] = ["max", "abs", "clamp", "length"];

/// The pair of that number.
pub fn pair(seed: u64) -> Pair {
    let files = ["one", "two"].map(|stem| File::new(stem, seed));
    Pair {
        hostile: [files[0].kernel(true), files[1].kernel(true)],
        tame: [files[0].kernel(false), files[1].kernel(false)],
    }
}

/// Numbers that look random (Knuth's MMIX constants).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % end
    }

    /// So many different names that are none of `taken`.
    fn names(&mut self, count: usize, taken: &[&'static str]) -> Vec<&'static str> {
        let mut names: Vec<&'static str> = Vec::new();
        while names.len() < count {
            let name = NAMES[self.below(NAMES.len())];
            if !names.contains(&name) && !taken.contains(&name) {
                names.push(name);
            }
        }
        names
    }
}

struct File {
    stem: &'static str,
    seed: u64,
    /// Two constants, two helpers, a struct and the kernel function.
    top: Vec<&'static str>,
    /// Two members of the struct.
    members: Vec<&'static str>,
    /// A parameter and a local variable of each of the helpers.
    locals: Vec<Vec<&'static str>>,
    /// A builtin function that the file may use.
    builtin: Option<&'static str>,
    /// The function of the imported file.
    shared: &'static str,
}

impl File {
    fn new(stem: &'static str, seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(2).wrapping_add(u64::from(stem == "two")));
        let top = random.names(6, &[]);
        let members = random.names(2, &[]);
        // A helper uses both constants, so its own names must not hide them.
        let locals = (0..2)
            .map(|helper| random.names(2, &[top[0], top[1], top[2 + helper], "clamp", "abs", "max", "length"]))
            .collect();
        let builtin = BUILTINS.into_iter().find(|name| !top.contains(name));
        let taken: Vec<&str> = top.iter().copied().chain(BUILTINS).chain(["source"]).collect();
        let shared = random.names(1, &taken)[0];
        Self { stem, seed, top, members, locals, builtin, shared }
    }

    fn kernel(&self, is_hostile: bool) -> Kernel {
        let name = |name: &str, tame: String| if is_hostile { name.to_owned() } else { tame };
        let top: Vec<String> =
            self.top.iter().enumerate().map(|(at, top)| name(top, format!("{}_top_{at}", self.stem))).collect();
        let members: Vec<String> =
            self.members.iter().enumerate().map(|(at, member)| name(member, format!("member_{at}"))).collect();
        let shared = name(self.shared, format!("{}_shared", self.stem));
        let mut words: Vec<String> = vec![format!("import super::shared::{shared};\n")];
        let mut add = |text: &str| words.extend(text.split(' ').map(str::to_owned));
        add(&format!("const {} = 0.375 ; const {} : f32 = 0.25 ;", top[0], top[1]));
        for helper in 0..2 {
            let [parameter, local] = [0, 1].map(|at| name(self.locals[helper][at], format!("local_{at}")));
            let value = format!("{parameter} * {} + {}", top[0], top[1]);
            let value = match self.builtin {
                Some("clamp") => format!("clamp ( {value} , vec4f ( ) , vec4f ( 9.0 ) )"),
                Some("length") => format!("{value} + 0.125 * length ( {parameter} )"),
                Some("max") => format!("max ( {value} , {parameter} )"),
                Some(builtin) => format!("{builtin} ( {value} )"),
                None => value,
            };
            let function = &top[2 + helper];
            add(&format!("fn {function} ( {parameter} : vec4f ) -> vec4f {{ let {local} = {value} ;"));
            add(&format!("return {local} * 0.5 + {parameter} * 0.{} ; }}", 2 + helper));
        }
        let [first, second] = [&members[0], &members[1]];
        add(&format!("struct {} {{ {first} : f32 , {second} : vec4f , }}", top[4]));
        let argument = self.argument(is_hostile);
        add(&format!("fn {} ( {argument} : vec4f ) -> vec4f {{", top[5]));
        add(&format!("var it = {} ( 0.5 , {argument} ) ; it . {second} = {} ( it . {second} ) ;", top[4], top[2]));
        add(&format!(
            "{} it . {second} += {} ( {shared} ( it . {second} ) * it . {first} ) ; }}",
            [
                "for ( var i = 0 ; i < 2 ; i ++ ) {",
                "var i = 0 ; while i < 2 { i ++ ;",
                "var i = 0 ; loop { if i == 2 { break ; } i ++ ;"
            ][self.seed as usize % 3],
            top[3]
        ));
        add(&format!("return it . {second} ; }}"));
        let text = if is_hostile { self.scattered(&words) } else { words.join(" ") };
        let factor = if self.stem == "one" { 0.75 } else { 0.625 };
        let shared = format!("fn {shared}(x: vec4f) -> vec4f {{ return x * {factor} + 0.0625; }}\n");
        Kernel { text, function: top[5].clone(), argument, shared }
    }

    /// The kernel's argument is the port `source`, unless a declaration that it uses has that name.
    fn argument(&self, is_hostile: bool) -> &'static str {
        let is_used = self.top.iter().position(|name| *name == "source").is_some_and(|at| at >= 2);
        if is_hostile && is_used { "picture" } else { "source" }
    }

    /// The words with white space and comments between them.
    fn scattered(&self, words: &[String]) -> String {
        let mut random = Random(!self.seed);
        let mut text = String::new();
        for word in words {
            text.push_str(word);
            text.push_str(match random.below(12) {
                0 => "\n",
                1 => " /* fn helper() { */ ",
                2 => " // const gain = }\n",
                3 => "\t/* /* nested */ } */",
                4 => "\r\n\n",
                _ => " ",
            });
        }
        text
    }
}
